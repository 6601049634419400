"""A main controller that hunts: what it senses, says and tells, seen on its pins and its port."""

from cgagen.bench_protocol import GO_MS
from cgagen.firmware.timing import least_step_ms, step_timeout_ms
from hil.main_reports import FIRST_NUMBERS, check_line, count_on
from hil.main_senses import check_sensing
from hil.main_trial import MainTrial
from hil.main_wanted import Wanted
from hil.target import Observation, Stimulus
from hil.trial import MS, want

FAST_LATE, SLOW_LATE = 1.25, 1.6
"""By how much `*BUSY` may come late, for a chip that computes fast between its looks, and for
another one. Choice."""

LEGS_TAKE_MS = 60
"""How long after GO the other side takes it. Choice: two frames."""

MOVEMENT_MS = 150
"""How much longer than the least the played legs move, behind a line of telemetry. Choice."""


def hunts(trial: MainTrial, wanted: Wanted) -> None:
    """Look, decide, say GO, report: a few times, then with legs that do not answer.

    Args:
        trial: a chip at its first look.
        wanted: what it is shown, and what it has to decide.
    """
    for number, (stimulus, right) in enumerate(wanted.hunts):
        _say_go(trial, stimulus, right)
        trial.go_on(LEGS_TAKE_MS)
        trial.other.set(0)
        _let_go(trial)
        _report(trial, stimulus, right)
        quiet = len(trial.edges)
        trial.go_on(least_step_ms(trial.robot) + MOVEMENT_MS)
        want(len(trial.edges) == quiet, "handshake", "senses while the legs move")
        if number == FIRST_NUMBERS - 1:
            count_on(trial)
        following = wanted.hunts[(number + 1) % len(wanted.hunts)][0]
        trial.present(following)
        trial.edges.clear()
        trial.forget()
        trial.other.set(None)
        want(trial.wait("look", 8), "handshake", "does not see that the legs stand")
        want(not trial.said, "faults", f"says {trial.said!r} of a whole movement")
    _cut_short(trial, *wanted.hunts[0])
    stimulus, right = wanted.hunts[0]
    _say_go(trial, stimulus, right)
    trial.forget()
    _let_go(trial)
    want(trial.wait("byte 13", 50), "faults", "no word of a GO that nobody took")
    want(trial.said == "*REFUSED\r", "faults", f"says {trial.said!r}")
    _report(trial, stimulus, right)
    trial.edges.clear()
    _say_go(trial, stimulus, right)
    _kept_waiting(trial, stimulus, right)


def _cut_short(trial: MainTrial, stimulus: Stimulus, right: Observation) -> None:
    """Legs that stand too soon have started anew, and that is said before the next look."""
    _say_go(trial, stimulus, right)
    trial.go_on(LEGS_TAKE_MS)
    trial.other.set(0)
    _let_go(trial)
    _report(trial, stimulus, right)
    least_ms = least_step_ms(trial.robot)
    trial.go_on(least_ms / 2)
    trial.forget()
    trial.edges.clear()
    trial.other.set(None)
    want(trial.wait("look", 20), "handshake", "does not go on after a movement that was cut short")
    said = "*CUT\r" if least_ms else ""
    want(trial.said == said, "faults", f"says {trial.said!r} of a movement that was cut short")


def _kept_waiting(trial: MainTrial, stimulus: Stimulus, right: Observation) -> None:
    """Legs that never stand are reported, and waited for."""
    trial.go_on(LEGS_TAKE_MS)
    trial.other.set(0)
    _let_go(trial)
    _report(trial, stimulus, right)
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
    want(trial.drives_all, "lines", "not all are driven")
    check_sensing(trial, stimulus)


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


def _report(trial: MainTrial, stimulus: Stimulus, right: Observation) -> None:
    """One line of telemetry says what was sensed and decided, where the robot's file wants it."""
    if trial.robot.telemetry:
        trial.forget()
        want(trial.wait("byte 13", 150), "telemetry", "no line")
        check_line(trial, stimulus, right)
