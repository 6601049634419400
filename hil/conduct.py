"""How each controller conducts itself on its pins and its port: what PROTOCOL.md says of it.

One chip at a time, the other one played by hand: sensing, GO and its refusal or three lines
alone, telemetry, faults, the bench's requests right and wrong, all movements, and resets.
"""

from cgagen.errors import CgagenError, LackingError
from hil.emulated import stopped
from hil.equivalence import Trial, Verdict, blocked, worst
from hil.judge_legs import judge_legs
from hil.judge_main import judge_main
from hil.judge_pair import judge_pair
from hil.main_wanted import wanted_of
from hil.subject import Subject
from hil.trial import FailedCheck


def try_conduct(subject: Subject) -> Trial:
    """Try both controllers of a robot, by their images alone; on three lines, also both at once."""
    trial = Trial("emulator:conduct")
    judges = [("main", _main), ("locomotion", _locomotion)]
    if subject.robot.link.step_line is None:
        judges.append(("locomotion", judge_pair))
    for number, (name, judge) in enumerate(judges):
        found, words = Verdict.PASS, ""
        try:
            judge(subject)
        except FailedCheck as failed:
            found, words = Verdict.FAIL, str(failed)
        except LackingError as error:
            found, words = Verdict.UNPROVEN, f"cannot be judged in full: {error}"
        except CgagenError as error:
            return blocked(trial.target, stopped(subject.where, error))
        if worst((trial.verdict, found)) is not trial.verdict:
            trial.verdict = found
            trial.reason = f"{subject.where}: {subject.files[name]}: {words}"
        trial.tried[number], trial.agreed[number] = 1, int(found is Verdict.PASS)
    return trial


def _main(subject: Subject) -> None:
    judge_main(subject, wanted_of(subject), subject.images["main"])


def _locomotion(subject: Subject) -> None:
    judge_legs(subject, subject.images["locomotion"])
