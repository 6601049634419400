"""A main controller that hunts: what it senses, says and tells, seen on its pins and its port."""

from cgagen.bench_protocol import (
    ANTENNA_KEYS,
    COMMAND_KEY,
    GO_MS,
    LIGHT_KEYS,
    SONAR_KEYS,
    STATE_KEY,
)
from cgagen.emulator.parts.sonar import middle_ns
from cgagen.firmware.timing import step_timeout_ms
from hil.layout import Place
from hil.main_trial import MainTrial
from hil.main_wanted import Wanted
from hil.target import Observation, Stimulus
from hil.trial import MS, want

FAST_LATE, SLOW_LATE = 1.25, 1.6
"""By how much `*BUSY` may come late, for a chip that computes fast between its looks, and for
another one. Choice."""

LEGS_TAKE_MS = 60
"""How long after GO the other side takes it. Choice: two frames."""

FIRST_NUMBERS, LATE_NUMBER = 3, 253
"""After so many decisions the program is made to believe that the next one is this one, as if it
had made all between: the number is a byte, and 0 follows 255. Choice, both."""

MOVEMENT_MS = 250
"""How long the played legs move. Choice: longer than a line of telemetry."""


def hunts(trial: MainTrial, wanted: Wanted, layout: dict[str, Place]) -> None:
    """Look, decide, say GO, report: a few times, then with legs that do not answer.

    Args:
        trial: a chip at its first look.
        wanted: what it is shown, and what it has to decide.
        layout: of its variables.
    """
    for number, (stimulus, right) in enumerate(wanted.hunts):
        _say_go(trial, stimulus, right)
        trial.go_on(LEGS_TAKE_MS)
        trial.other.set(0)
        _let_go(trial)
        _report(trial, _told(number), stimulus, right)
        quiet = len(trial.edges)
        trial.go_on(MOVEMENT_MS)
        want(len(trial.edges) == quiet, "handshake", "senses while the legs move")
        if number == FIRST_NUMBERS - 1 and trial.robot.telemetry:
            size_bits, element, _ = layout["decisions"]
            trial.chip.registers.write(size_bits, element, LATE_NUMBER)
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
    number = len(wanted.hunts)
    _report(trial, _told(number), stimulus, right)
    trial.edges.clear()
    _say_go(trial, stimulus, right)
    _kept_waiting(trial, _told(number + 1), stimulus, right)


def _told(number: int) -> int:
    """Return the number that telemetry gives a decision, see `FIRST_NUMBERS`."""
    return number if number < FIRST_NUMBERS else (LATE_NUMBER + number - FIRST_NUMBERS) % 256


def _kept_waiting(trial: MainTrial, number: int, stimulus: Stimulus, right: Observation) -> None:
    """Legs that never stand are reported, and waited for."""
    trial.go_on(LEGS_TAKE_MS)
    trial.other.set(0)
    _let_go(trial)
    _report(trial, number, stimulus, right)
    trial.edges.clear()
    trial.forget()
    began_ns = trial.now_ns
    least_ms = step_timeout_ms(trial.robot)
    most_ms = least_ms * (FAST_LATE if trial.fast else SLOW_LATE)
    want(trial.wait("byte 13", most_ms), "faults", "no word of legs that never stand")
    want(trial.said == "*BUSY\r", "faults", f"says {trial.said!r}")
    want(trial.now_ns - began_ns > least_ms * MS, "faults", "loses its patience early")
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
    """One line of telemetry says what was sensed and decided, where the robot's file wants it."""
    role = trial.robot.role
    if not trial.robot.telemetry:
        return
    sides = [1 - bent for bent in stimulus.touched]
    keys = [*SONAR_KEYS[role], *(LIGHT_KEYS if stimulus.lights else ()), *ANTENNA_KEYS]
    values = [*stimulus.sonars, *stimulus.lights, *sides, right.state, right.command]
    words = zip([*keys, STATE_KEY, COMMAND_KEY], values, strict=True)
    line = f":{number} " + " ".join(f"{key}{value}" for key, value in words) + "\r"
    trial.forget()
    want(trial.wait("byte 13", 150), "telemetry", "no line")
    want(trial.said == line, "telemetry", f"{trial.said!r}, not {line!r}")


def _check_sensing(trial: MainTrial, stimulus: Stimulus) -> None:
    """Triggers, gaps and charging are as long as the robot's file has them, in order."""
    robot = trial.robot
    pulses = _pulses(trial)
    for sonar, count in zip(robot.sonars, stimulus.sonars, strict=True):
        name = f"sonar {sonar.name}"
        trigger, *echoes = pulses.pop(sonar.pins[0], [(0, 0)])
        echoes += pulses.pop(sonar.pins[-1], [])  # an SRF04's, which has a line of its own
        least = int(robot.echo.trigger_us * 1_000)
        unit = robot.main.pulsout_unit_ns
        if trial.asked_ns is not None:
            gap = trigger[0] - trial.asked_ns
            limit = robot.echo.trigger_gap_ms * MS
            want(limit <= gap, "sensing", f"{name}: {gap / MS:.2f} ms behind the trigger before")
        trial.asked_ns = trigger[0]
        want(least <= trigger[1] < least + unit, "sensing", f"{name}: trigger {trigger[1]} ns")
        want(len(echoes) == bool(count), "sensing", f"{name}: asked more than once")
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
    rose: dict[int, int] = {}
    for time_ns, pin, level in trial.edges:
        if level == 1:
            rose[pin] = time_ns
        elif pin in rose:
            pulses.setdefault(pin, []).append((rose[pin], time_ns - rose.pop(pin)))
    return pulses
