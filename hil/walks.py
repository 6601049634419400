"""What the legs make of each command: all eight movements, read back from twelve pulse trains."""

from cgagen.errors import CgagenError, RigError
from cgagen.words import COMMANDS
from hil.equivalence import Trial, Verdict, blocked
from hil.lone import Lone
from hil.subject import Subject

SEEN_MS = 40
"""After so long the legs have seen the line high, and take a command. Ref: PROTOCOL.md."""


def try_walks(subject: Subject) -> Trial:
    """Give a locomotion controller each command, and compare what its servos do.

    A robot without a step line cannot be told so, and nothing is said then.
    """
    trial = Trial("emulator:locomotion")
    if subject.robot.link.step_line is None:
        trial.verdict = Verdict.UNPROVEN
        trial.reason = f"{subject.robot.name} has no step line, by which a movement is told"
        return trial
    try:
        lone = Lone(subject, mute=True)
        lone.stand()
        for command, movement in enumerate(COMMANDS[subject.role]):
            lone.run(SEEN_MS)
            lone.go(command)
            walk = lone.walk()
            wrong = walk.made.reason if walk else "nobody took it"
            right = walk is not None and walk.made.command == walk.asked == command
            trial.tried[command], trial.agreed[command] = 1, int(right)
            if not right and not trial.reason:
                trial.verdict = Verdict.FAIL
                trial.reason = (
                    f"{subject.where}: {subject.files['locomotion']}: {movement} was asked for: "
                    f"{wrong or 'its servos make another movement'}"
                )
    except CgagenError as error:
        return blocked(trial.target, RigError(f"{subject.where}: on the emulator: {error}"))
    if lone.uncommanded and not trial.reason:
        trial.verdict = Verdict.FAIL
        trial.reason = f"{subject.where}: moved without a command {lone.uncommanded[0]}"
    return trial
