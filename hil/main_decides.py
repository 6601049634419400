"""What a main controller decides, from a snapshot before its first decision: readings and genes."""

from cgagen.emulator.routine import Routine
from hil.anchors import Anchors
from hil.main_trial import MainTrial
from hil.main_wanted import Wanted
from hil.simulated import commands_by_state
from hil.target import Stimulus
from hil.trial import MS, want

ARRIVAL_NS = 8_000 * MS
"""How long a program may take to its first decision. Choice: three times what it takes."""


class Decider:
    """The routine that decides by itself, with the counts where sensing leaves them.

    Args:
        trial: a chip before its first decision.
        anchors: where the routine and its registers are.
        at: where a call begins; the routine's beginning, or its READ.

    Raises:
        FailedCheck: it never comes there.
    """

    def __init__(self, trial: MainTrial, anchors: Anchors, at: int) -> None:
        chip, self._anchors = trial.chip, anchors
        limit_ns = trial.now_ns + ARRIVAL_NS
        arrived = chip.run_until(lambda: chip.pc == at, limit_ns) and chip.machine.gosubs
        want(bool(arrived), "hang", "never comes to its decision")
        self.stop = chip.machine.memory.slots[chip.slot].header(chip.machine.gosubs[-1])
        self.routine = Routine(chip, self.stop)
        self._pins = tuple(enumerate(trial.robot.link.main_pins))

    def words(self, stimulus: Stimulus) -> list[int]:
        """Return the register file as sensing leaves it."""
        return self._anchors.sensed(list(self.routine.before), stimulus)

    def decide(self, stimulus: Stimulus) -> tuple[int, int]:
        """Return state and command."""
        self.routine.call(self.words(stimulus))
        return self._anchors.state_in(self.routine.words), self._command()

    def look_up(self, state: int) -> int:
        """Return the command of a state."""
        self.routine.call(self._anchors.with_state(list(self.routine.before), state))
        return self._command()

    def _command(self) -> int:
        return sum((self.routine.latch >> pin & 1) << bit for bit, pin in self._pins)


def decisions(trial: MainTrial, wanted: Wanted, anchors: Anchors) -> None:
    """Have every reading decided. Raises FailedCheck at the first that is decided otherwise."""
    decider = Decider(trial, anchors, anchors.places.entry)
    for stimulus, right in wanted.decisions:
        seen = decider.decide(stimulus)
        if seen != (right.state, right.command):
            want(False, "decide", f"{stimulus.text()}: {seen}, not {right.state, right.command}")


def genes(trial: MainTrial, anchors: Anchors) -> frozenset[int]:
    """Look up the command of every state, with the state put where it is looked up.

    With masking, no reading leads to some of them; the image's own instructions read them all.

    Returns:
        The states whose commands were right: all of them.
    """
    decider = Decider(trial, anchors, anchors.read)
    commands = commands_by_state(trial.subject)
    for state, command in enumerate(commands):
        seen = decider.look_up(state)
        want(seen == command, "table", f"gene {state} is {seen}, not {command}")
    return frozenset(range(len(commands)))
