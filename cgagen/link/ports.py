"""Serial ports of this machine: what they are, and which of them is meant.

Nothing in here opens a port. Where an answer from behind a port is needed, the caller brings the
question along.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from serial.tools import list_ports

from cgagen.errors import RigError

AUTO = "auto"
BY_SERIAL = "id:"

CHOICES = "auto, a device such as /dev/ttyUSB0, id:SERIAL, rfc2217://HOST:PORT, socket://HOST:PORT"
"""What `--port` takes, in the words of its help."""


NONE = "this machine has no serial port: plug the adapter in (a container sees none)"


@dataclass(frozen=True, slots=True)
class PortInfo:
    """A port of this machine.

    Attributes:
        device: its path.
        vendor: USB vendor number; None where the port is not on USB.
        product: USB product number; None likewise.
        serial: the adapter's serial number; "" where it has none.
        words: what the adapter calls itself; "" where it says nothing.
    """

    device: str
    vendor: int | None = None
    product: int | None = None
    serial: str = ""
    words: str = ""

    @property
    def usb(self) -> str:
        """The USB numbers as `lsusb` prints them; "" where there are none.

        >>> PortInfo("/dev/ttyUSB0", 0x0403, 0x6001).usb
        '0403:6001'
        """
        if self.vendor is None or self.product is None:
            return ""
        return f"{self.vendor:04x}:{self.product:04x}"

    def to_text(self) -> str:
        """Return the port as one short line.

        >>> PortInfo("/dev/ttyUSB0", 0x0403, 0x6001, "A50285BI", "FT232R USB UART").to_text()
        '/dev/ttyUSB0 (0403:6001, id:A50285BI, FT232R USB UART)'
        """
        facts = [self.usb, f"{BY_SERIAL}{self.serial}" if self.serial else "", self.words]
        known = ", ".join(fact for fact in facts if fact)
        return f"{self.device} ({known})" if known else self.device


def all_ports() -> tuple[PortInfo, ...]:
    """Return the serial ports of this machine by name, those on USB first."""
    found = [
        PortInfo(
            port.device,
            port.vid,
            port.pid,
            port.serial_number or "",
            (port.product or port.description or "").replace("n/a", ""),
        )
        for port in list_ports.comports()
    ]
    return tuple(sorted(found, key=lambda port: (port.vendor is None, port.device)))


Answers = Callable[[str], bool]
"""Whether what is wanted answers on the port of this name."""


def choose_port(
    name: str, answers: Answers | None = None, ports: Sequence[PortInfo] | None = None
) -> str:
    """Return the device path or URL that a user's words mean.

    Args:
        name: one of `CHOICES`.
        answers: for "auto": asked where more than one port could be meant; None where asking
            would disturb.
        ports: those to choose from; None for the machine's.

    Raises:
        RigError: there is no such port, or more than one.

    >>> choose_port("/dev/ttyUSB3"), choose_port("socket://bench:4000")
    ('/dev/ttyUSB3', 'socket://bench:4000')
    >>> choose_port("id:B2", ports=[PortInfo("/dev/ttyUSB0", 1, 2, "A1"),
    ...                             PortInfo("/dev/ttyUSB1", 1, 2, "B2")])
    '/dev/ttyUSB1'
    """
    if name != AUTO and not name.startswith(BY_SERIAL):
        return name
    known = all_ports() if ports is None else ports
    if name == AUTO:
        return _the_only(known, answers)
    serial = name.removeprefix(BY_SERIAL)
    found = [port.device for port in known if port.serial and port.serial == serial]
    if len(found) != 1:
        many = f"{len(found)} adapters have" if found else "no adapter has"
        raise RigError(f"{name}: {many} this serial number; {_listed(known)}")
    return found[0]


def _the_only(known: Sequence[PortInfo], answers: Answers | None) -> str:
    """Return the only adapter on USB; what else there is has to be named.

    A port of the board itself is there on most machines, with nothing behind it or something that
    is none of ours.
    """
    candidates = [port for port in known if port.vendor is not None]
    if answers is not None and len(candidates) > 1:
        candidates = [port for port in candidates if answers(port.device)]
    if len(candidates) == 1:
        return candidates[0].device
    what = "answers" if answers is not None else "could be meant"
    if not candidates:
        there = what if answers is not None else "is there"
        name_it = "; name one with --port" if known else ""
        raise RigError(f"auto: no USB adapter {there}; {_listed(known)}{name_it}")
    names = ", ".join(port.device for port in candidates)
    raise RigError(f"auto: more than one USB adapter {what} ({names}); name one with --port")


def _listed(known: Iterable[PortInfo]) -> str:
    text = ", ".join(port.to_text() for port in known)
    if not text:
        return NONE
    return f"the ports are {text}"
