"""A CAN bus as a target needs it: frames that may be a rig's, bounded waits, and what else came.

python-can is imported when a bus is opened, not before.
"""

import time
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from cgagen.errors import RigError
from hil.frames import Frame
from hil.messages import BITRATE, BY_ID, FRAME_BYTES, RIG
from hil.rig_url import RigUrl

if TYPE_CHECKING:
    import can

SEND_S = 2.0
"""How long one frame may take to get out. Choice."""

BUS_OFF = 0x40
"""Bit of an error frame's identifier, as Linux has it (CAN_ERR_BUSOFF)."""


class CanLine:
    """One end of a bus.

    Args:
        place: where.
        name: what messages call it.

    Attributes:
        errors: error frames.
        foreign: frames that are no rig's.
        malformed: a rig's identifiers with another length than 8 bytes.
    """

    def __init__(self, place: RigUrl, name: str) -> None:
        self.errors = self.foreign = self.malformed = 0
        self._place = place
        self._name = name
        self._bus: can.BusABC | None = None

    def open(self) -> None:
        """Open it, whatever configuration files and environment say.

        Raises:
            RigError: no such interface or adapter.
        """
        import can

        interface, channel = self._place.interface, self._place.channel
        quick = "://" in channel or channel.startswith("/dev/pts/")
        options: dict[str, Any] = {"sleep_after_open": 0} if interface == "slcan" and quick else {}
        try:
            self._bus = can.Bus(
                interface=interface,
                channel=channel,
                bitrate=BITRATE,
                ignore_config=True,
                **options,
            )
        except Exception as error:  # every maker's driver has errors of its own
            raise RigError(
                f"{self._name}: cannot be opened ({error}); look at the adapter, its name and its "
                "driver"
            ) from error

    def close(self) -> None:
        """Close it. Harmless when repeated, and when the adapter is gone."""
        bus, self._bus = self._bus, None
        if bus is not None:
            with suppress(Exception):
                bus.shutdown()
            # slcan leaves its port open where it cannot say goodbye any more
            port = getattr(bus, "serialPortOrig", None)
            if port is not None:
                with suppress(Exception):
                    port.close()

    def send(self, frames: tuple[Frame, ...]) -> None:
        """Send frames in this order.

        Raises:
            RigError: the bus does not take them.
        """
        import can

        bus = self._open_bus()
        for one in frames:
            message = can.Message(arbitration_id=one.id, data=one.data, is_extended_id=False)
            try:
                bus.send(message, timeout=SEND_S)
            except Exception as error:
                raise self._lost("sending", error) from error

    def receive(self, wait_s: float) -> Frame | None:
        """Return the next frame of a rig; None where none came in time.

        Raises:
            RigError: the bus is closed, its adapter gone, or the controller off the bus.
        """
        deadline_s = time.monotonic() + wait_s
        while True:
            try:
                message = self._open_bus().recv(max(deadline_s - time.monotonic(), 0))
            except RigError:
                raise
            except Exception as error:
                raise self._lost("listening", error) from error
            if message is None:
                return None
            one = self._sorted(message)
            if one is not None or time.monotonic() >= deadline_s:
                return one

    def odd(self) -> str:
        """Return what else was on the bus, in words."""
        return (
            f"{self.errors} error frames, {self.foreign} of other devices, {self.malformed} "
            "of a wrong length"
        )

    def _sorted(self, message: "can.Message") -> Frame | None:
        if message.is_error_frame:
            self.errors += 1
            if message.arbitration_id & BUS_OFF:
                raise RigError(
                    f"{self._name}: the adapter is off the bus after too many errors; look at the "
                    f"wiring, the termination and the bitrate ({BITRATE} bit/s), and restart it"
                )
            return None
        known = BY_ID.get(message.arbitration_id)
        plain = not (message.is_extended_id or message.is_remote_frame or message.is_fd)
        if known is None or known.sender != RIG or not plain:
            self.foreign += 1
            return None
        if len(message.data) != FRAME_BYTES:
            self.malformed += 1
            return None
        return Frame(message.arbitration_id, bytes(message.data))

    def _open_bus(self) -> "can.BusABC":
        if self._bus is None:
            raise RigError(f"{self._name}: is not open; open it first")
        return self._bus

    def _lost(self, what: str, error: Exception) -> RigError:
        return RigError(f"{self._name}: lost while {what} ({error}); look at the adapter")
