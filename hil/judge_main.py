"""Checks of a main controller: what it senses, decides, says and tells, by pins and by words."""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

from cgagen.bench_protocol import (
    ANTENNA_KEYS,
    COMMAND_KEY,
    END,
    GO_MS,
    LIGHT_KEYS,
    LISTEN_MS,
    MAIN_SLICE_MS,
    READING_MS,
    SONAR_KEYS,
    STATE_KEY,
    Banner,
    banner_text,
    dump_request,
    parse_dump,
    reading_text,
)
from cgagen.emulator.chip import Coverage
from cgagen.emulator.parts.photocell import Photocell
from cgagen.emulator.parts.sonar import Sonar, middle_ns
from cgagen.emulator.parts.whisker import Whisker
from cgagen.emulator.routine import Routine
from cgagen.stamp.compiled import Compiled
from cgagen.stamp.image import Image
from hil.forced import Forced
from hil.layout import layout_of, line_of_label
from hil.simulated import SimulatedTarget, commands_by_state
from hil.stimuli import Level as StimuliLevel
from hil.stimuli import neutral, stimuli_of, ties
from hil.subject import Subject
from hil.target import Observation, Stimulus
from hil.trial import BYTE_NS, MS, Trial, want

SLACK_NS = 1_000_000
"""What instructions between two waits may take. Choice: five times what they do."""

BUSY_MS = (2_600, 3_200)
"""When `*BUSY` has to come: past the longest movement. Choice."""

ARRIVAL_NS = 3_000 * MS
"""How long a program may take to its first decision. Choice: three times what it takes."""

LEGS_TAKE_MS = 60
"""How long after GO the other side takes it. Choice: two frames."""

MOVEMENT_MS = 250
"""How long the played legs move. Choice: longer than a line of telemetry."""


@dataclass(frozen=True)
class Wanted:
    """What a main controller is tried with, and what it has to decide.

    Attributes:
        decisions: for `Decide` by itself, from a snapshot.
        hunts: for the pins, one after the other; then for the words of a bench.
    """

    decisions: tuple[tuple[Stimulus, Observation], ...]
    hunts: tuple[tuple[Stimulus, Observation], ...]


def wanted_of(subject: Subject) -> Wanted:
    """Return stimuli and the simulator's decisions."""
    robot, target = subject.robot, SimulatedTarget(subject)
    listed = list(dict.fromkeys([*stimuli_of(robot, StimuliLevel.SMOKE), *ties(robot)]))
    decisions = zip(listed, target.decide_all(listed), strict=True)
    hunts = _hunts(subject)
    return Wanted(tuple(decisions), tuple(zip(hunts, target.decide_all(hunts), strict=True)))


def _hunts(subject: Subject) -> list[Stimulus]:
    """Return readings whose counts all differ, each sensor silent, touched, lit in turn."""
    plain = neutral(subject.robot)
    number, lights = len(plain.sonars), bool(plain.lights)
    rising = tuple(2_000 + 111 * index for index in range(number))
    gone = tuple(0 if index == number - 1 else 7_000 - index for index in range(number))
    far = tuple(9_000 + index for index in range(number))
    rows: list[tuple[tuple[int, ...], tuple[bool, bool], tuple[int, int]]] = [
        (rising, (False, False), (0, 0)),
        (rising[::-1], (True, False), (300, 0)),
        (gone, (False, True), (0, 400)),
        (far, (True, True), (500, 600)),
        (far, (False, False), (1_000, 900)),
        (rising, (False, False), (0, 700)),
    ]
    return [Stimulus(sonars, touched, lit if lights else ()) for sonars, touched, lit in rows]


class MainTrial(Trial):
    """A main controller with all its sensors forced, and ears on its pins."""

    def __init__(self, subject: Subject, image: Image, coverage: Coverage | None = None) -> None:
        super().__init__(subject, "main", image, coverage)
        robot, bench = subject.robot, self.bench
        sonars = bench.parts_of(Sonar)
        self._forced = [Forced() for _ in robot.sonars]
        for sonar, forced in zip(robot.sonars, self._forced, strict=True):
            sonars[f"sonar_{sonar.name}"].spoilers.append(forced)
        self._whiskers = list(bench.parts_of(Whisker).values())
        self._cells = list(bench.parts_of(Photocell).values())
        self.edges: list[tuple[int, int, int | None]] = []
        sensors = [pin for sonar in robot.sonars for pin in sonar.pins]
        sensors += [one.pin for one in robot.light.sensors] if robot.light else []
        for pin in sensors:
            bench.end(f"main.P{pin}").listen(self._listener(pin))
        self.first_pin = robot.sonars[0].pins[0]
        line = robot.link.step_line
        self.step_bit = 1 << (line.main_pin if line else 0)
        self.line_bits = sum(1 << pin for pin in robot.link.main_pins)

    def _listener(self, pin: int) -> Callable[[int | None], None]:
        def changed(level: int | None) -> None:
            self.edges.append((self.now_ns, pin, level))
            if level == 1:
                self.event("look" if pin == self.first_pin else "")

        return changed

    @property
    def drives(self) -> int:
        """Pins that are outputs."""
        return self.chip.pins.directions

    def lines(self) -> int:
        """Return the command that is on the wires."""
        return sum((self.bench.wire(f"command_{bit}").level or 0) << bit for bit in range(3))

    def present(self, stimulus: Stimulus) -> None:
        """Put this in front of the sensors."""
        main = self.robot.main
        for forced, one in zip(self._forced, stimulus.sonars, strict=True):
            forced.width_ns = middle_ns(one, main.pulsin_unit_ns) if one else None
        for whisker, bent in zip(self._whiskers, stimulus.touched, strict=True):
            whisker.touch(bent)
        for cell, one in zip(self._cells, stimulus.lights, strict=True):
            cell.drain(middle_ns(one, main.rctime_unit_ns) if one else None)


def judge_main(
    subject: Subject, wanted: Wanted, compiled: Compiled, coverage: Coverage | None = None
) -> None:
    """Try a main controller.

    Raises:
        FailedCheck: by the first check that finds something.
        CgagenError: what it does is impossible on the bench.
    """
    trial = MainTrial(subject, compiled.image, coverage)
    trial.present(wanted.hunts[0][0])
    _start(trial)
    before, seen = trial.bench.snapshot(), len(trial.edges)
    _decide(trial, wanted, compiled)
    trial.bench.restore(before)
    if subject.genome is not None:
        genes(trial, compiled)
        trial.bench.restore(before)
    del trial.edges[seen:]
    _hunt(trial, wanted)
    trial = MainTrial(subject, compiled.image, coverage)
    trial.present(neutral(subject.robot))
    _bench(trial, wanted, compiled.image)
    _late_hello(MainTrial(subject, compiled.image, coverage))


def _start(trial: MainTrial) -> None:
    """Banner and prompts, with no line touched; then the first look."""
    robot, subject = trial.robot, trial.subject
    want(trial.wait("look", 2_500), "hang", "never looks at its sensors")
    digest = subject.sources["main"].split("Source:  ")[1][:8]
    wanted = banner_text(Banner(1, "main", robot.name, subject.genome_digest, digest)) + "\r"
    want(trial.said.rstrip(">") == wanted, "banner", f"says {trial.said!r}")
    prompts = trial.heard_ns[len(wanted) :]
    slices = [b - a for a, b in pairwise([*prompts, trial.now_ns])]
    want(len(slices) > 1, "banner", "does not listen")
    least = MAIN_SLICE_MS * MS + BYTE_NS // 2
    want(min(slices) >= least, "banner", "slices too short")
    want(max(slices) <= least + BYTE_NS + SLACK_NS, "banner", "slices too long")
    whole = trial.now_ns - prompts[0]
    want(whole >= LISTEN_MS * MS, "banner", f"listens for {whole / MS:.0f} ms")
    want(whole - slices[0] < LISTEN_MS * MS + 20 * MS, "banner", f"listens {whole / MS:.0f} ms")
    lines = trial.line_bits | trial.step_bit
    want(not trial.drives & lines, "handshake", "drives a line before its first decision")


# -- Decisions from a snapshot ----------------------------------------------------------------


class Decider:
    """`Decide` by itself, with the counts where sensing leaves them.

    Args:
        trial: a chip before its first decision.
        compiled: its source says where the routine and its variables are.

    Raises:
        FailedCheck: it never comes to the routine.
    """

    def __init__(self, trial: MainTrial, compiled: Compiled) -> None:
        line = line_of_label(compiled.source, "Decide") or 0
        entry = next(one.bit for one in compiled.source_map.statements if one.line > line)
        chip, robot = trial.chip, trial.robot
        limit_ns = trial.now_ns + ARRIVAL_NS
        arrived = chip.run_until(lambda: chip.pc == entry, limit_ns) and chip.machine.gosubs
        want(bool(arrived), "hang", "never comes to Decide")
        layout = layout_of(compiled.source)
        echo = layout["echo"].element
        self._places = [echo + index for index in range(len(robot.sonars))]
        lights = ("lightleft", "lightright") if robot.light else ()
        self._places += [layout[name].element for name in lights]
        self._antennas, self._state = layout["antennas"].element, layout["state"].element
        self.stop = chip.machine.memory.slots[chip.slot].header(chip.machine.gosubs[-1])
        self.routine = Routine(chip, self.stop)
        self._pins = tuple(enumerate(robot.link.main_pins))

    def words(self, stimulus: Stimulus) -> list[int]:
        """Return the register file as sensing leaves it."""
        words = list(self.routine.before)
        counts = (*stimulus.sonars, *stimulus.lights)
        for place, count in zip(self._places, counts, strict=True):
            words[place] = count
        shift = 4 * (self._antennas & 3)
        word = words[self._antennas >> 2]
        words[self._antennas >> 2] = word & ~(0xF << shift) | _levels(stimulus) << shift
        return words

    def decide(self, stimulus: Stimulus) -> tuple[int, int]:
        """Return state and command."""
        self.routine.call(self.words(stimulus))
        state = self.routine.words[self._state >> 1] >> 8 * (self._state & 1) & 0xFF
        return state, sum((self.routine.latch >> pin & 1) << bit for bit, pin in self._pins)


def _decide(trial: MainTrial, wanted: Wanted, compiled: Compiled) -> None:
    decider = Decider(trial, compiled)
    for stimulus, right in wanted.decisions:
        seen = decider.decide(stimulus)
        if seen != (right.state, right.command):
            want(False, "decide", f"{stimulus.text()}: {seen}, not {right.state, right.command}")


def genes(trial: MainTrial, compiled: Compiled) -> frozenset[int]:
    """Look up all 64 genes, with obstacle and target put where they are looked up.

    With masking, no reading leads to some of them; the image's own instructions read them all.

    Returns:
        The states whose genes were right: all of them.
    """
    source = trial.subject.sources["main"].split("\n")
    line = next(n for n, text in enumerate(source, 1) if text.startswith("  state = obstacle"))
    entry = next(one.bit for one in compiled.source_map.statements if one.line >= line)
    chip, layout = trial.chip, layout_of(compiled.source)
    arrived = chip.run_until(lambda: chip.pc == entry, trial.now_ns + ARRIVAL_NS)
    want(bool(arrived and chip.machine.gosubs), "hang", "never comes to its table")
    routine = Routine(chip, chip.machine.memory.slots[chip.slot].header(chip.machine.gosubs[-1]))
    for state, command in enumerate(commands_by_state(trial.subject)):
        words = list(routine.before)
        for name, value in (("obstacle", state >> 3), ("target", state & 7)):
            place = layout[name].element
            shift = 4 * (place & 3)
            words[place >> 2] = words[place >> 2] & ~(0xF << shift) | value << shift
        routine.call(words)
        pins = enumerate(trial.robot.link.main_pins)
        seen = sum((routine.latch >> pin & 1) << bit for bit, pin in pins)
        want(seen == command, "table", f"gene {state} is {seen}, not {command}")
    return frozenset(range(len(commands_by_state(trial.subject))))


# -- Hunting by pins --------------------------------------------------------------------------


def _hunt(trial: MainTrial, wanted: Wanted) -> None:
    """Look, decide, say GO, report: a few times, then with legs that do not answer."""
    for number, (stimulus, right) in enumerate(wanted.hunts):
        _say_go(trial, stimulus, right)
        trial.go_on(LEGS_TAKE_MS)
        trial.other.set(0)
        _let_go(trial)
        _report(trial, number, stimulus, right)
        quiet = len(trial.edges)
        trial.go_on(MOVEMENT_MS)
        want(len(trial.edges) == quiet, "handshake", "senses while the legs move")
        following = wanted.hunts[(number + 1) % len(wanted.hunts)][0]
        trial.present(following)
        trial.edges.clear()
        trial.other.set(None)
        want(trial.wait("look", 8), "handshake", "does not see that the legs stand")
    stimulus, right = wanted.hunts[0]
    _say_go(trial, stimulus, right)
    trial.forget()
    _let_go(trial)
    want(trial.wait("byte 13", 50), "faults", "no word of a GO that nobody took")
    want(trial.said == "*REFUSED\r", "faults", f"says {trial.said!r}")
    _report(trial, len(wanted.hunts), stimulus, right)
    trial.edges.clear()
    _say_go(trial, stimulus, right)
    _kept_waiting(trial, len(wanted.hunts) + 1, stimulus, right)


def _kept_waiting(trial: MainTrial, number: int, stimulus: Stimulus, right: Observation) -> None:
    """Legs that never stand are reported, and waited for."""
    trial.go_on(LEGS_TAKE_MS)
    trial.other.set(0)
    _let_go(trial)
    _report(trial, number, stimulus, right)
    trial.edges.clear()
    trial.forget()
    began_ns = trial.now_ns
    want(trial.wait("byte 13", BUSY_MS[1]), "faults", "no word of legs that never stand")
    want(trial.said == "*BUSY\r", "faults", f"says {trial.said!r}")
    want(trial.now_ns - began_ns > BUSY_MS[0] * MS, "faults", "loses its patience early")
    trial.go_on(50)
    want(not trial.edges, "handshake", "senses while the legs move")
    trial.other.set(None)
    want(trial.wait("look", 8), "handshake", "does not go on after *BUSY")
    want(trial.wait("step 0", 1_000), "handshake", "no GO after *BUSY")


def _say_go(trial: MainTrial, stimulus: Stimulus, right: Observation) -> None:
    """It looks, and says GO with the right command on the lines."""
    want(trial.wait("step 0", 1_000), "handshake", "never says GO")
    want(trial.lines() == right.command, "lines", f"{stimulus.text()}: {trial.lines()}")
    want(trial.drives & trial.line_bits == trial.line_bits, "lines", "not all are driven")
    _check_sensing(trial, stimulus)


def _let_go(trial: MainTrial) -> None:
    """GO is held for its time, and no longer."""
    left_ms = GO_MS - (LEGS_TAKE_MS if trial.step.level == 0 and _held_by(trial) else 0)
    trial.go_on(left_ms - 0.5)
    want(bool(trial.drives & trial.step_bit), "handshake", "says GO too shortly")
    trial.go_on(1.3)
    want(not trial.drives & trial.step_bit, "handshake", "does not let the step line go")


def _held_by(trial: MainTrial) -> bool:
    """Whether the played legs hold the line too."""
    return trial.other.name in trial.step.drivers


def _report(trial: MainTrial, number: int, stimulus: Stimulus, right: Observation) -> None:
    """One line of telemetry says what was sensed and decided."""
    role = trial.robot.role
    sides = [1 - bent for bent in stimulus.touched]
    keys = [*SONAR_KEYS[role], *(LIGHT_KEYS if stimulus.lights else ()), *ANTENNA_KEYS]
    values = [*stimulus.sonars, *stimulus.lights, *sides, right.state, right.command]
    words = zip([*keys, STATE_KEY, COMMAND_KEY], values, strict=True)
    line = f":{number} " + " ".join(f"{key}{value}" for key, value in words) + "\r"
    trial.forget()
    want(trial.wait("byte 13", 150), "telemetry", "no line")
    want(trial.said == line, "telemetry", f"{trial.said!r}, not {line!r}")


def _check_sensing(trial: MainTrial, stimulus: Stimulus) -> None:
    """Triggers, rests and charging are as long as the robot's file has them, in order."""
    robot = trial.robot
    ended_ns = None
    pulses = _pulses(trial)
    for sonar, count in zip(robot.sonars, stimulus.sonars, strict=True):
        name = f"sonar {sonar.name}"
        trigger, *echoes = pulses.pop(sonar.pins[0], [(0, 0)])
        least = int(robot.echo.trigger_us * 1_000)
        unit = robot.main.pulsout_unit_ns
        if ended_ns is not None:
            rest = trigger[0] - ended_ns
            limit = robot.echo.rest_ms * MS
            want(limit <= rest, "sensing", f"{name}: rest {rest / MS:.2f} ms")
        want(least <= trigger[1] < least + unit, "sensing", f"{name}: trigger {trigger[1]} ns")
        want(len(echoes) == bool(count), "sensing", f"{name}: asked more than once")
        last = echoes[-1] if echoes else trigger
        ended_ns = last[0] + last[1]
    sensors = robot.light.sensors if robot.light else ()
    for sensor, count in zip(sensors, stimulus.lights, strict=True):
        charged = pulses.get(sensor.pin, [])
        want(len(charged) == 1 or not count, "sensing", f"light {sensor.name}: charged {charged}")
        if count and robot.light:
            high = charged[0][1] - middle_ns(count, robot.main.rctime_unit_ns)
            least = robot.light.charge_ms * MS
            want(least <= high, "sensing", f"light {sensor.name}: charged for {high} ns")


def _pulses(trial: MainTrial) -> dict[int, list[tuple[int, int]]]:
    """Return start and width of the high pulses on each sensor's pin."""
    pulses: dict[int, list[tuple[int, int]]] = {}
    rose: dict[int, int] = {trial.first_pin: trial.edges[0][0]} if trial.edges else {}
    for time_ns, pin, level in trial.edges:
        if level == 1:
            rose[pin] = time_ns
        elif pin in rose:
            pulses.setdefault(pin, []).append((rose[pin], time_ns - rose.pop(pin)))
    return pulses


# -- Bench mode -------------------------------------------------------------------------------


def _bench(trial: MainTrial, wanted: Wanted, image: Image) -> None:
    _said(trial, "?Hab", "!Hab")
    _ignored(trial)
    for number, (stimulus, right) in enumerate(wanted.hunts):
        _question(trial, f"?Q{number}x", stimulus, right)
    _bad_readings(trial, wanted.hunts[0][0])
    for request in ("?Zab", "?D/0", "?D0p", "?D10", "?Mab"):
        _said(trial, request, f"!E{request[2:]}")
    _said(trial, "?Hcd", "!Hcd")
    _dump(trial, image)
    _table(trial)
    lines = trial.line_bits | trial.step_bit
    want(not trial.drives & lines, "bench", "drives a line in bench mode")
    stimulus, right = wanted.hunts[1]
    trial.present(stimulus)
    _all_bits(trial, stimulus)
    _said(trial, "?Xzz", "!Xzz")
    want(trial.wait("look", 20), "bench", "does not hunt after leaving")
    want(trial.wait("step 0", 1_000), "bench", "does not say GO after leaving")
    want(trial.lines() == right.command, "bench", f"says {trial.lines()} after leaving")


def _all_bits(trial: MainTrial, stimulus: Stimulus) -> None:
    """Leave bits that sensing does not write in the word of the antennas, and a right sum."""
    counts = (*stimulus.sonars, *stimulus.lights)
    words = reading_text(3, counts).rstrip(END).split(" ")
    words[:2] = "F", f"{counts[0] - (0xF - 3):04X}"
    said = trial.ask("?Qff", " ".join(words) + END)
    want("!Qff" in said, "bench", f"an antennas' word of four bits is answered {said!r}")


def _late_hello(trial: MainTrial) -> None:
    """A hello in the last slice is heard, too."""
    for _ in range(LISTEN_MS // MAIN_SLICE_MS - 1):
        want(trial.wait("byte 62", 200), "bench", "no prompt")
    _said(trial, "?Hzz", "!Hzz")


def _said(trial: MainTrial, request: str, answer: str) -> None:
    said = trial.ask(request)
    want(said == f"{request}{answer}\r", "bench", f"{request} is answered {said!r}")


def _levels(stimulus: Stimulus) -> int:
    return (not stimulus.touched[0]) | (not stimulus.touched[1]) << 1


def _question(trial: MainTrial, request: str, stimulus: Stimulus, right: Observation) -> None:
    reading = reading_text(_levels(stimulus), (*stimulus.sonars, *stimulus.lights))
    said = trial.ask(request, reading)
    answer = f"!{request[1:]}{right.state:02X}{right.command:X}\r"
    want(said == f"{request}>{reading}{answer}", "bench", f"{request} is answered {said!r}")


def _bad_readings(trial: MainTrial, stimulus: Stimulus) -> None:
    """A number that changed on its way is refused, whichever it is; so is silence."""
    counts = (*stimulus.sonars, *stimulus.lights)
    words = reading_text(3, counts).rstrip(END).split(" ")
    for at in range(len(words)):
        bad = words.copy()
        bad[at] = f"{int(bad[at], 16) ^ 1:0{len(bad[at])}X}"
        reading = " ".join(bad) + END
        said = trial.ask("?Qsx", reading)
        want(said == f"?Qsx>{reading}!Esx\r", "bench", f"bad number {at} is answered {said!r}")
    want(trial.wait("byte 62", 100), "bench", "no prompt")
    trial.go_on(2)
    trial.forget()
    trial.host.send(b"?Qnn")
    want(trial.wait("byte 62", 100), "bench", "no prompt for readings")
    began_ns = trial.now_ns
    want(trial.wait("byte 33", READING_MS + 10), "bench", "waits too long for readings")
    want(trial.now_ns - began_ns >= READING_MS * MS, "bench", "does not wait for readings")
    want(trial.wait("byte 13", 50) and trial.said == "?Qnn>!Enn\r", "bench", "no refusal")


def _ignored(trial: MainTrial) -> None:
    """What is no request is not answered."""
    trial.wait("byte 62", 500)
    trial.go_on(2)
    trial.forget()
    trial.host.send(b"!H77")
    trial.go_on(150)
    want("!" not in trial.said.removeprefix("!H77"), "bench", f"answers {trial.said!r}")


def _dumped(trial: MainTrial, first: int, last: int) -> bytes:
    request = dump_request(first, last)
    said = trial.ask(request, limit_ms=2_000)
    found = [line for line in map(parse_dump, said.split("\r")) if line]
    want([line[0] for line in found] == list(range(first, last, 16)), "dump", "addresses")
    want(said.endswith(f"\r!{request[1:]}\r"), "dump", "no end")
    return b"".join(line[1] for line in found)


def _dump(trial: MainTrial, image: Image) -> None:
    for first, last in ((0, 63), (2016, 2047)):
        data = _dumped(trial, first, last)
        want(data == image.eeprom[first : last + 1], "dump", "bytes")


def _table(trial: MainTrial) -> None:
    """The whole table is what was evolved, also where no reading leads."""
    commands = bytes(commands_by_state(trial.subject))
    at = trial.subject.images["main"].eeprom.find(commands)
    data = _dumped(trial, at // 32 * 32, (at + len(commands) - 1) // 32 * 32 + 31)
    want(commands in data, "table", "is another one")
