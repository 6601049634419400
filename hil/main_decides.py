"""What a main controller decides, from a snapshot before its first decision: readings and genes."""

from cgagen.emulator.routine import Routine
from cgagen.stamp.compiled import Compiled
from hil.layout import layout_of, line_of_label
from hil.main_trial import MainTrial, levels
from hil.main_wanted import Wanted
from hil.simulated import commands_by_state
from hil.target import Stimulus
from hil.trial import MS, want

ARRIVAL_NS = 3_000 * MS
"""How long a program may take to its first decision. Choice: three times what it takes."""


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
        words[self._antennas >> 2] = word & ~(0xF << shift) | levels(stimulus) << shift
        return words

    def decide(self, stimulus: Stimulus) -> tuple[int, int]:
        """Return state and command."""
        self.routine.call(self.words(stimulus))
        state = self.routine.words[self._state >> 1] >> 8 * (self._state & 1) & 0xFF
        return state, sum((self.routine.latch >> pin & 1) << bit for bit, pin in self._pins)


def decisions(trial: MainTrial, wanted: Wanted, compiled: Compiled) -> None:
    """Have every reading decided. Raises FailedCheck at the first that is decided otherwise."""
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
