"""Hosts and chips, carried on by one loop: what is ready, then what time does."""

import selectors
import socket
import threading
import time
from collections.abc import Sequence

from cgagen.closing import Closing
from cgagen.emulator.bench import Bench
from cgagen.emulator.clock import NEVER_NS
from cgagen.serve.endpoint import Endpoint
from cgagen.serve.paced import RUN_NS, SLICE_NS

SILENCE_S = 0.02
"""How long a host may think before the chip's time goes on. Choice."""

LOST_NS = 1_000_000_000
"""With `realtime`, a bench that is so far behind gives up catching up. Choice."""


class Server(Closing):
    """Serves ports of a bench; use it in a `with`, or call `run`.

    Args:
        bench: nobody else may run it meanwhile.
        endpoints: of chips on it.
        realtime: never faster than the real thing. Otherwise as fast as can be, but while a
            chip listens.

    Attributes:
        endpoints: see above.
        failure: what ended the thread of a `with`, if anything did.
    """

    def __init__(self, bench: Bench, endpoints: Sequence[Endpoint], realtime: bool = False) -> None:
        self.endpoints = tuple(endpoints)
        self.failure: BaseException | None = None
        self._bench = bench
        self._realtime = realtime
        self._began = (time.monotonic(), bench.clock.now_ns)
        self._ended = False
        self._wake, self._woken = socket.socketpair()
        self._wake.setblocking(False)
        self._thread = threading.Thread(target=self._run_in_thread, name="served", daemon=True)

    @property
    def url(self) -> str:
        """What pyserial opens to get at the first chip."""
        return self.endpoints[0].url

    @property
    def control(self) -> str | None:
        """Where DTR and BREAK of the first chip are; None where `url` carries them."""
        return self.endpoints[0].control

    def open(self) -> None:
        """Serve in a thread of its own."""
        self._thread.start()

    def stop(self) -> None:
        """Let `run` end soon; may be called from anywhere."""
        self._ended = True
        self._wake.send(b".")

    def close(self) -> None:
        """End the thread, if there is one, and let all hosts go. A `run` must have ended."""
        if self._thread.is_alive():
            self.stop()
            self._thread.join()
        for endpoint in self.endpoints:
            endpoint.close()
        self._wake.close()
        self._woken.close()

    def run(self, limit_ns: int = NEVER_NS) -> None:
        """Serve until `stop`, or until the bench's clock has come so far."""
        while not self._ended and self._bench.clock.now_ns < limit_ns:
            self.turn(limit_ns)

    def turn(self, limit_ns: int = NEVER_NS) -> None:
        """Do what is ready; where nothing is, let time go on by a slice."""
        present = [one for one in self.endpoints if one.present]
        slow = any(one.port.listens for one in present)
        if not self._serve_ready(present, slow) and present and not any(e.full for e in present):
            ns = SLICE_NS if slow else RUN_NS
            now_ns = self._bench.clock.now_ns
            present[0].port.port.run(min(now_ns + ns, limit_ns))
        for endpoint in self.endpoints:
            endpoint.deliver()

    def _run_in_thread(self) -> None:
        try:
            self.run()
        except BaseException as error:
            self.failure = error
            for endpoint in self.endpoints:
                endpoint.hang_up()

    def _serve_ready(self, present: list[Endpoint], slow: bool) -> bool:
        """Wait for hosts as long as that is right; returns whether one had something to say."""
        spoken = False
        with selectors.DefaultSelector() as selector:
            selector.register(self._woken, selectors.EVENT_READ)
            for endpoint in self.endpoints:
                for number, (events, ready) in endpoint.wanted().items():
                    selector.register(number, events, ready)
            found = selector.select(self._wait_s(present, slow))
            if not present:
                self._began = (time.monotonic(), self._bench.clock.now_ns)
            for key, events in found:
                if key.data is None:
                    return True
                key.data()
                spoken = spoken or bool(events & selectors.EVENT_READ)
        return spoken

    def _wait_s(self, present: list[Endpoint], slow: bool) -> float | None:
        if not present:
            return SILENCE_S if any(one.sleepless for one in self.endpoints) else None
        if any(one.full for one in present):
            return SILENCE_S
        if self._realtime:
            return self._ahead_s()
        return SILENCE_S if slow else 0.0

    def _ahead_s(self) -> float:
        """Return how far the bench is ahead of the real thing."""
        began_s, began_ns = self._began
        passed_ns = round((time.monotonic() - began_s) * 1e9)
        ahead_ns = self._bench.clock.now_ns - began_ns - passed_ns
        if ahead_ns < -LOST_NS:
            self._began = (time.monotonic(), self._bench.clock.now_ns)
        return max(0.0, ahead_ns / 1e9)
