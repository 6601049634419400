"""One emulated robot that is watched: every GO, every movement, every word on both ports.

With `mute`, the main controller is kept in reset and the test itself works the lines, so that
every phase and every lag between the two chips can be had.
"""

from dataclasses import dataclass

from cgagen.bench_protocol import PROMPT
from hil.colony_bench import colony_bench
from hil.gait_reader import Reading, Train
from hil.player import Player, step_wire
from hil.referee import Referee
from hil.subject import Subject
from hil.target import Stimulus

WORD = "robot"
TESTER = "tester"
OFF_NS = 1 << 60
MS = 1_000_000
LISTENS_NS = 60 * MS
"""Longer than from one prompt to the next."""
LOOKED_NS = MS
"""How long before they pull the line the legs have last looked at it, at most. They never take a
GO so soon after having let go of it themselves: a frame lies between. Choice: twice what it is."""


@dataclass(frozen=True, slots=True)
class Walk:
    """One time in which the locomotion controller held the step line.

    Attributes:
        accepted_ns: when it took it.
        asked: the command lines when it took it.
        made: the movement that the servos made.
        train: their pulses.
    """

    accepted_ns: int
    asked: int
    made: Reading
    train: Train


class Lone:
    """A robot on a bench of its own, from power-up.

    Args:
        subject: its programs.
        text: another bench than the robot's own.
        mute: keep the main controller in reset; `go` takes its place.

    Attributes:
        line: the step line.
        walks: movements that were told, the newest last.
        uncommanded: what its servos did without being told.
        words: all that both chips said on their ports, by chip, without telemetry.
        go_ns: when the step line fell while the legs stood.
        rise_ns: when it rose.
        booting: the locomotion controller begins anew and centres its legs, up to its first prompt.
    """

    def __init__(self, subject: Subject, text: str | None = None, mute: bool = False) -> None:
        self.subject = subject
        self.bench = colony_bench({WORD: subject}, None if text is None else {WORD: text})
        self.player = Player(subject, self.bench, WORD)
        self.walks: list[Walk] = []
        self.uncommanded: list[str] = []
        self.words: dict[str, str] = {"locomotion": ""}
        self.go_ns: list[int] = []
        self.rise_ns: list[int] = []
        self.booting = True
        self._asked: tuple[int, int] = (0, 0)
        self._prompt_ns = 0
        self.line, self._go_driver, driver = step_wire(subject, self.bench, WORD)
        lines = {WORD: self.line}
        referee = Referee("watch", self.bench.clock, lines, {WORD: driver}, holds=False)
        referee.accepted, referee.finished = self._accepted, self._finished
        self.referee = self.bench.add_part(referee)
        self.line.listen(self._changed)
        self.bench.host(f"{WORD}_locomotion").heard = self._heard
        if mute:
            self._go_driver = TESTER
            self.reset("main", OFF_NS)

    @property
    def now_ns(self) -> int:
        """The time."""
        return self.bench.clock.now_ns

    def show(self, stimulus: Stimulus) -> None:
        """Put a reading before the sensors, from now on."""
        self.player.show(stimulus)

    def run(self, ms: float) -> None:
        """Let time go by."""
        self.bench.run(self.now_ns + round(ms * MS))

    def walk(self, walks: int = 1, limit_ms: int = 8_000) -> Walk | None:
        """Go on until so many more movements are finished; None where they are not in time."""
        wanted, end_ns = len(self.walks) + walks, self.now_ns + limit_ms * MS
        while len(self.walks) < wanted and self.now_ns < end_ns:
            self.bench.run(min(self.now_ns + 20 * MS, end_ns))
        return self.walks[-1] if len(self.walks) >= wanted else None

    def stand(self, limit_ms: int = 5_000) -> None:
        """Go on until the legs stand and wait for GO."""
        end_ns = self.now_ns + limit_ms * MS
        while not self._waits() and self.now_ns < end_ns:
            self.run(1)

    def _waits(self) -> bool:
        """Whether the locomotion controller has listened to a host to the end and waits for GO."""
        quiet_ns = self.now_ns - self._prompt_ns
        return not self.booting and quiet_ns > LISTENS_NS and self.line.level == 1

    def go(self, command: int, hold_ms: float = 100.0) -> None:
        """Do as the main controller: command, step line low, and let go of it."""
        for bit in range(3):
            self.bench.wire(f"{WORD}_command_{bit}").drive(TESTER, command >> bit & 1)
        self.line.drive(TESTER, 0)
        self.run(hold_ms)
        self.line.drive(TESTER, None)

    def reset(self, chip: str, hold_ns: int = 0) -> None:
        """Reset a chip; its legs are then centred without having been told."""
        self.bench.reset(f"{WORD}_{chip}", hold_ns)  # a movement under way is cut short here
        if chip == "locomotion":
            self.booting = True

    def asked(self) -> int:
        """Return what the command lines say now."""
        levels = [self.bench.wire(f"{WORD}_command_{bit}").level or 0 for bit in range(3)]
        return sum(level << bit for bit, level in enumerate(levels))

    def _accepted(self, _word: str) -> None:
        self._rested()
        self.player.told = not self.booting and self._go_is_said()
        if not self.player.told and not self.booting:
            self.uncommanded.append(f"at {self.now_ns} ns: takes a GO that nobody gave")
        self._asked = self.now_ns, self.asked()

    def _go_is_said(self) -> bool:
        """Whether GO is on the line, or was when the legs last looked at it."""
        ended_ns = self.rise_ns[-1] if self.rise_ns else -LOOKED_NS
        return self._go_driver in self.line.drivers or self.now_ns - ended_ns < LOOKED_NS

    def _finished(self, _word: str) -> None:
        began_ns, asked = self._asked
        gait, train = self.player.gait, self.player.gait.take()
        self.walks.append(Walk(began_ns, asked, gait.read(train), train))

    def _rested(self) -> None:
        train = self.player.gait.take()
        if self.booting:
            return
        trouble = self.player.gait.rested(train)
        if trouble:
            self.uncommanded.append(f"before {self.now_ns} ns: {trouble}")

    def _changed(self, level: int | None) -> None:
        if level == 1:
            self.rise_ns.append(self.now_ns)
        elif self.rise_ns:
            self.go_ns.append(self.now_ns)

    def _heard(self, byte: int) -> None:
        self.words["locomotion"] += chr(byte)
        if chr(byte) == PROMPT:
            self._prompt_ns = self.now_ns
            if self.booting:
                self.booting = False
                self.player.gait.rest = self.player.gait.take().whole_frames()[-1]
