"""Both controllers of a robot on three lines, and what a reset of the main one lets through.

While it begins anew its lines float and say 000, which is Forward, and nothing says that nobody
has commanded it. So the robot may walk as many Forwards as begin in that time, one behind the
other, and nothing else that its lines do not say (FIDELITY.md).
"""

from hil.free import MS, Free, Made
from hil.stimuli import neutral
from hil.subject import Subject
from hil.trial import want

RESET_MS = (0, 600)
"""After the end of a movement. Choice: before the lines are read for the next one, and in it."""

FORWARD = 0
"""What undriven lines say."""

BEHIND = 3
"""Movements that are looked at after the one in which it is reset. Choice: in the last of them
it has long decided."""


def judge_pair(subject: Subject) -> None:
    """Reset the main controller while the robot walks.

    Raises:
        FailedCheck: by the first check that finds something.
        CgagenError: what it does is impossible on the bench.
    """
    for time_ms in RESET_MS:
        free = Free(subject)
        free.show(neutral(subject.robot))
        want(free.walk(2), "hang", "does not walk")
        free.run(time_ms)
        before, reset_ns = len(free.made), free.now_ns
        free.reset_main()
        want(free.walk(BEHIND + 1), "hang", "does not walk on when the other Stamp is reset")
        want(len(free.told_ns) == 2, "resets", "the main controller drives no lines after a reset")
        _check(free.made[before:], free.told_ns[-1] - reset_ns)


def _check(made: list[Made], floating_ns: int) -> None:
    for one in made:
        command, said = one.reading.command, " or ".join(map(str, sorted(one.said)))
        seen = one.reading.reason or f"{command} is walked"
        want(command in one.said, "resets", f"the lines say {said}, and {seen}")
    last = made[-1].reading.command
    free = [one for one in made if one.reading.command == FORWARD and last != FORWARD]
    most = 1 + floating_ns // min((one.time_ns for one in free), default=floating_ns)
    words = f"{len(free)} Forwards in {floating_ns / MS:.0f} ms of floating lines"
    want(len(free) <= most, "resets", words)
