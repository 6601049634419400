"""The emulated robot on a rig's bench: with faults to switch, and an eye on the servos."""

from functools import partial

from cgagen.bench_protocol import Banner, parse_banner
from cgagen.emulator.bench import Bench
from cgagen.emulator.clock import Clock
from cgagen.emulator.parts import fault, sonar
from cgagen.emulator.parts.sonar_faults import NoEcho
from cgagen.emulator.parts.wire_faults import Open, Stuck
from hil.emulated import PinsTarget
from hil.frames import Question
from hil.messages import TICK_NS, Fault

FRAME_LIMIT_NS = 60_000_000
"""How long a servo frame may take. Choice: servos go limp after 50 ms."""


class ServoFrames:
    """Sorts the pulses of all servos into frames.

    A frame ends when a servo has its pulse that has had one in this frame already.

    Args:
        clock: the bench's.
        servos: how many.

    Attributes:
        taken: whole frames: ns of each servo's pulse, 0 for none.
    """

    def __init__(self, clock: Clock, servos: int) -> None:
        self.taken: list[tuple[int, ...]] = []
        self._clock = clock
        self._servos = servos
        self._rose: dict[int, int] = {}
        self._now: dict[int, int] = {}

    def begin(self) -> None:
        """Forget everything; the next pulse is the first."""
        self.taken, self._rose, self._now = [], {}, {}

    def changed(self, servo: int, level: int | None) -> None:
        """Take an edge of a servo's wire."""
        now_ns = self._clock.now_ns
        if level == 1:
            self._rose[servo] = now_ns
        elif servo in self._rose:
            if servo in self._now:
                self.taken.append(tuple(self._now.get(n, 0) for n in range(self._servos)))
                self._now = {}
            self._now[servo] = now_ns - self._rose.pop(servo)


class RigRobot(PinsTarget):
    """Both Stamps with all that is wired to them, asked in raw counts."""

    def equip(self, bench: Bench) -> None:
        """Put the faults on the bench, all of them off, and listen to the servos."""
        robot = self.subject.robot
        servos = robot.servo_set.servos
        self.servos = ServoFrames(bench.clock, len(servos))
        for number, servo in enumerate(servos):
            wire = bench.wire(f"servo_{servo.leg}_{servo.joint}")
            wire.listen(partial(self.servos.changed, number))
        self.faults = {kind: bench.add_part(one) for kind, one in self._faults(bench).items()}

    @property
    def banner(self) -> Banner | None:
        """What the main controller has said of itself after power-up."""
        return self._banner

    def open(self) -> None:
        """Switch it on; see `PinsTarget.open`."""
        self._banner = None
        super().open()
        self._banner = parse_banner(self.said.partition("\r")[0])

    def answer(self, question: Question) -> tuple[int, int] | None:
        """Let it decide; returns its command and the ns that it took, None for no decision."""
        self.present_ns(
            [ticks * TICK_NS or None for ticks in question.echoes],
            question.touched,
            [ticks * TICK_NS or None for ticks in question.drains],
        )
        if question.fault:
            self.faults[Fault(question.fault)].switch(True)
        return self.look()

    def fired(self, kind: int) -> bool:
        """Say whether the fault of the last question has made a difference."""
        return self.faults[Fault(kind)].fired > 0

    def walk(self, frames: int) -> list[tuple[int, ...]]:
        """Go on from the last decision for so many servo frames; fewer where pulses stay away."""
        self.servos.begin()
        while len(self.servos.taken) < frames:
            seen = len(self.servos.taken)
            self.bench.run(self.bench.clock.now_ns + FRAME_LIMIT_NS)
            if len(self.servos.taken) == seen:
                break
        return self.servos.taken[:frames]

    def _faults(self, bench: Bench) -> dict[Fault, fault.Fault]:
        robot, clock = self.subject.robot, bench.clock
        sonars = list(bench.parts_of(sonar.Sonar).values())
        found: dict[Fault, fault.Fault] = {}
        for n, one in enumerate(sonars):
            kind = Fault(Fault.NO_ECHO_0 + n)
            found[kind] = NoEcho(f"fault_{kind.name}", clock, one, None)
        stuck = [(Fault.TOUCHED_L + n, one.pin, 0) for n, one in enumerate(robot.antennas)]
        stuck += [(Fault.TORN_L + n, one.pin, 1) for n, one in enumerate(robot.antennas)]
        lights = robot.light.sensors if robot.light else ()
        stuck += [(Fault.DARK_L + n, one.pin, 1) for n, one in enumerate(lights)]
        for number, pin, level in stuck:
            kind = Fault(number)
            end = bench.end(f"main.P{pin}")
            found[kind] = Stuck(f"fault_{kind.name}", clock, end, level, None)
        for bit, pin in enumerate(robot.link.main_pins):
            kind = Fault(Fault.COMMAND_CUT_0 + bit)
            end = bench.end(f"main.P{pin}")
            found[kind] = Open(f"fault_{kind.name}", clock, end, None)
        return found

    servos: ServoFrames
    faults: dict[Fault, fault.Fault]
    _banner: Banner | None = None
