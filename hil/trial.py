"""One Stamp on trial: its robot's bench with the other Stamp held in reset and played by hand.

What a robot would do to the chip is done by the trial: the other end of the step line, the
command lines, and the computer on the programming port.
"""

from collections.abc import Callable

from cgagen.bench_protocol import BAUD, BYTE_GAP_MS, PROMPT, PROMPT_GAP_MS
from cgagen.emulator.chip import Coverage
from cgagen.emulator.parts.signal import Signal
from cgagen.emulator.wires import Wire
from cgagen.stamp.image import Image
from hil.emulated import robot_bench
from hil.subject import CHIPS, Subject

MS = 1_000_000
FOREVER_NS = 1 << 60
BYTE_NS = 10 * 1_000_000_000 // BAUD
FIRST_PROMPT_MS = 4_000
"""From a reset; a locomotion controller brings its legs up before. Choice."""
STEP_PART = "other_side"
RESET_NS = 2 * MS
"""How long a reset is held. Choice: two bytes."""


class FailedCheck(Exception):  # noqa: N818  a verdict, no error of anybody's
    """A check has found something.

    Attributes:
        check: its name.
        reason: what it found.
    """

    def __init__(self, check: str, reason: str) -> None:
        super().__init__(f"{check}: {reason}")
        self.check = check
        self.reason = reason


def want(held: bool, check: str, reason: str) -> None:
    """Raise FailedCheck unless something holds."""
    if not held:
        raise FailedCheck(check, reason)


class Trial:
    """A chip, powered up on its bench.

    Args:
        subject: the robot.
        name: which of its chips; the other one stays in reset.
        image: what is in the chip.
        coverage: where to count what is executed; None for nowhere.

    Attributes:
        bench: the robot's.
        has_step: whether there is a step line; the paper's own wiring is three lines alone.
        text: what the computer has heard, its own words included.
        heard_ns: when each of these bytes was there.
    """

    def __init__(
        self, subject: Subject, name: str, image: Image, coverage: Coverage | None = None
    ) -> None:
        self.subject, self.robot = subject, subject.robot
        self.bench = bench = robot_bench(subject.robot, {**subject.images, name: image})
        self.chip = bench.chip(name)
        self.chip.coverage = coverage or self.chip.coverage
        (other,) = set(CHIPS) - {name}
        bench.reset(other, FOREVER_NS)
        self.has_step = subject.robot.link.step_line is not None
        self._line: list[tuple[Wire, Signal]] = []
        self.host = bench.host(name)
        self.text = bytearray()
        self.heard_ns: list[int] = []
        self._taken: int | None = None
        self._wanted: Callable[[str], bool] = lambda _event: False
        self.host.heard = self._heard
        if self.has_step:
            wire = bench.wire("step")
            self._line.append((wire, bench.add_part(Signal(STEP_PART, bench.clock, wire))))
            wire.listen(lambda level: self.event(f"step {level}"))

    @property
    def step(self) -> Wire:
        """The step line of a robot that has one."""
        return self._line[0][0]

    @property
    def other(self) -> Signal:
        """The other end of the step line."""
        return self._line[0][1]

    @property
    def now_ns(self) -> int:
        """The bench's time."""
        return self.bench.clock.now_ns

    def event(self, name: str) -> None:
        """Note that something happened; ends a `wait` for it."""
        if self._wanted(name):
            self.bench.clock.stop()

    def wait(self, event: str, limit_ms: float) -> bool:
        """Go on until something happens; returns whether it did in time."""
        self._wanted = event.__eq__
        self.bench.run(self.now_ns + int(limit_ms * MS))
        self._wanted = lambda _event: False
        return self.bench.clock.stopped

    def go_on(self, time_ms: float) -> None:
        """Let time pass."""
        self.bench.run(self.now_ns + int(time_ms * MS))

    def forget(self) -> None:
        """Forget what was heard."""
        self._taken = None
        self.text.clear()
        self.heard_ns.clear()

    def reset(self) -> None:
        """Reset the chip, for as long as a byte takes that was cut short; forget what was before.

        It begins anew a tenth of a millisecond later.
        """
        self.bench.reset(self.chip.name, RESET_NS)
        self.go_on((RESET_NS - 0.1 * MS) / MS)
        self.forget()

    @property
    def said(self) -> str:
        """What was heard, as text."""
        return self.text.decode("latin-1")

    def ask(self, request: str, reading: str = "", limit_ms: float = 300) -> str:
        """Say a request at the next prompt, and its readings at the one behind it, once.

        Returns:
            All that was on the line since, up to the end of the answer; "" for no prompt; what
            came unasked since the last answer, where there was anything but prompts.
        """
        if not self.wait(f"byte {ord(PROMPT)}", FIRST_PROMPT_MS):
            return ""
        stray = "" if self._taken is None else self.said[self._taken :].strip(PROMPT)
        if stray:
            return f"unasked: {stray}"
        self.go_on(PROMPT_GAP_MS)
        self.forget()
        self.host.send(request.encode("latin-1"))
        if reading:
            self._say_slowly(reading)
        until_ns = self.now_ns + int(limit_ms * MS)
        while self.now_ns < until_ns and not self._answered():
            self.wait("byte 13", (until_ns - self.now_ns) / MS)
        self._taken = len(self.text)
        return self.said

    def _answered(self) -> bool:
        return "\r" in self.said.rpartition("!")[2] and "!" in self.said

    def _say_slowly(self, reading: str) -> None:
        self.wait(f"byte {ord(PROMPT)}", 100)
        self.go_on(PROMPT_GAP_MS)
        for letter in reading:
            self.host.send(letter.encode("latin-1"))
            self.go_on(BYTE_NS / MS + BYTE_GAP_MS)

    def _heard(self, byte: int) -> None:
        self.text.append(byte)
        self.heard_ns.append(self.now_ns)
        self.event(f"byte {byte}")


def answered(trial: Trial, request: str, answer: str) -> None:
    """Say a request, which has to be answered so."""
    said = trial.ask(request)
    want(said == f"{request}{answer}\r", "bench", f"{request} is answered {said!r}")


def ignores(trial: Trial, text: str) -> None:
    """Say what is no request, which must not be answered."""
    trial.wait(f"byte {ord(PROMPT)}", 500)
    trial.go_on(PROMPT_GAP_MS)
    trial.forget()
    trial.host.send(text.encode("latin-1"))
    trial.go_on(150)
    want("!" not in trial.said.removeprefix(text), "bench", f"answers {trial.said!r}")
