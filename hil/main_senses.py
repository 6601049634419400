"""What a main controller does on its sensors' pins in one look, by the robot's file."""

from cgagen.emulator.parts.sonar import middle_ns
from hil.main_trial import MainTrial
from hil.target import Stimulus
from hil.trial import MS, want

FAST_GAP_MS, SLOW_GAP_MS = 5, 10
"""By how much the gap between two triggers may be longer than the robot's file has it, behind an
echo that is shorter than the gap: a decision takes no longer than it must. Choice: twice what it
is."""


def check_sensing(trial: MainTrial, stimulus: Stimulus) -> None:
    """Triggers, gaps and charging are as long as the robot's file has them, in order."""
    robot = trial.robot
    pulses = pulses_of(trial)
    most_ns = (robot.echo.trigger_gap_ms + (FAST_GAP_MS if trial.fast else SLOW_GAP_MS)) * MS
    before = 0  # no echo, or no sonar: how long that takes is the chip's affair
    for sonar, count in zip(robot.sonars, stimulus.sonars, strict=True):
        name = f"sonar {sonar.name}"
        trigger, *echoes = pulses.pop(sonar.pins[0], [(0, 0)])
        echoes += pulses.pop(sonar.pins[-1], [])  # an SRF04's, which has a line of its own
        least = int(robot.echo.trigger_us * 1_000)
        unit = robot.main.pulsout_unit_ns
        if trial.asked_ns is not None:
            gap = trigger[0] - trial.asked_ns
            limit = robot.echo.trigger_gap_ms * MS
            words = f"{name}: {gap / MS:.2f} ms behind the trigger before"
            want(limit <= gap and (gap <= most_ns or not before), "sensing", words)
        trial.asked_ns, before = trigger[0], count
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


def pulses_of(trial: MainTrial) -> dict[int, list[tuple[int, int]]]:
    """Return start and width of the high pulses on each sensor's pin."""
    pulses: dict[int, list[tuple[int, int]]] = {}
    rose: dict[int, int] = {}
    for time_ns, pin, level in trial.edges:
        if level == 1:
            rose[pin] = time_ns
        elif pin in rose:
            pulses.setdefault(pin, []).append((rose[pin], time_ns - rose.pop(pin)))
    return pulses
