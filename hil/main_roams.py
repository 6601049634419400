"""A main controller on three lines: it looks and decides all the time, and waits for nobody.

There is no GO: what its lines say at any instant is what the legs may walk next. So they change
at once, from one decision to the next, and never show anything else between.
"""

from cgagen.emulator.chip import Chip
from hil.main_reports import FIRST_NUMBERS, check_line, count_on
from hil.main_senses import check_sensing
from hil.main_trial import MainTrial
from hil.main_wanted import Wanted
from hil.trial import want

ROUND_MS = 1_000
"""From one look to the next, at most, without the rests between sonars. Choice."""

FLOATING, PARTIAL = -1, -2
"""Shown while none of the lines is driven, or only some."""


def roams(trial: MainTrial, wanted: Wanted) -> None:
    """Look, decide, tell and report, one look behind the other.

    Args:
        trial: a chip at its first look.
        wanted: what it is shown, and what it has to decide.
    """
    limit_ms = ROUND_MS + len(trial.robot.sonars) * trial.robot.echo.trigger_gap_ms
    before = FLOATING
    rows = [*wanted.hunts, wanted.hunts[0]]
    for number, (stimulus, right) in enumerate(rows):
        trial.edges[:] = trial.edges[-1:]  # the trigger with which this look has begun
        trial.forget()
        shown = _Shown(trial)
        want(trial.wait("look", limit_ms), "hang", "does not look again")
        shown.end()
        following = rows[(number + 1) % len(rows)][0]
        trial.present(following)
        *edges, began = trial.edges
        trial.edges[:] = edges
        check_sensing(trial, stimulus)
        trial.edges[:] = [began]
        text = f"{stimulus.text()}: {trial.lines()}"
        want(trial.lines() == right.command and trial.drives_all, "lines", text)
        way = list(dict.fromkeys([before, right.command]))
        want(shown.values == way, "lines", f"show {shown.values} on their way, not {way}")
        if trial.robot.telemetry:
            check_line(trial, stimulus, right)
        else:
            want(not trial.said, "telemetry", f"says {trial.said!r}")
        if number == FIRST_NUMBERS - 1:
            count_on(trial)
        before = right.command


class _Shown:
    """What the lines show between instructions: each command once in a row.

    Args:
        trial: looked at from now on.

    Attributes:
        values: commands, `FLOATING` and `PARTIAL`.
    """

    def __init__(self, trial: MainTrial) -> None:
        self.values: list[int] = []
        self._trial = trial
        self.end = trial.chip.on_instruction(self._look)

    def _look(self, _chip: Chip) -> None:
        driven = self._trial.drives & self._trial.line_bits
        seen = PARTIAL if driven else FLOATING
        if driven == self._trial.line_bits:
            seen = self._trial.lines()
        if self.values[-1:] != [seen]:
            self.values.append(seen)
