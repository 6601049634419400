"""How each controller conducts itself on its pins and its port: what PROTOCOL.md says of it.

One chip at a time, the other one played by hand: sensing, GO and its refusal, telemetry, faults,
the bench's requests right and wrong, and all movements.
"""

from collections.abc import Callable

from cgagen.errors import CgagenError, SourceError
from hil.emulated import stopped
from hil.equivalence import Trial, Verdict, blocked, worst
from hil.judge_legs import judge_legs
from hil.judge_main import judge_main
from hil.main_wanted import wanted_of
from hil.registers import Compile
from hil.subject import Subject
from hil.trial import FailedCheck


def try_conduct(subject: Subject, compile_source: Compile) -> Trial:
    """Try both controllers of a robot.

    Args:
        subject: what is on trial; without a step line the checks are not made for it.
        compile_source: the tokenizer; a main source that is not the image's leaves its chip out.
    """
    trial = Trial("emulator:conduct")
    if subject.robot.link.step_line is None:
        trial.verdict = Verdict.NOT_TRIED
        trial.reason = f"{subject.robot.name} has no step line, on which these checks are made"
        return trial
    for number, (name, judge) in enumerate(_judges(subject, compile_source).items()):
        try:
            judge()
        except FailedCheck as failed:
            trial.reason = trial.reason or f"{subject.where}: {subject.files[name]}: {failed}"
            trial.verdict = Verdict.FAIL
        except CgagenError as error:
            return blocked(trial.target, stopped(subject.where, error))
        except (LookupError, StopIteration):
            trial.verdict = worst((trial.verdict, Verdict.UNPROVEN))
            trial.reason = trial.reason or (
                f"{subject.where}: {subject.files[name]} lacks a line, a variable or a pulse that "
                "every generated program has"
            )
        else:
            trial.agreed[number] = 1
        trial.tried[number] = 1
    return trial


def _judges(subject: Subject, compile_source: Compile) -> dict[str, Callable[[], None]]:
    """Return what judges each chip; a main controller's needs the names in its source."""
    judges: dict[str, Callable[[], None]] = {}
    try:
        compiled = compile_source(subject.sources["main"], subject.files["main"])
    except SourceError:
        compiled = None
    image = subject.images["main"]
    if compiled is not None and compiled.image.eeprom == image.eeprom:
        judges["main"] = lambda: judge_main(subject, wanted_of(subject), compiled)
    judges["locomotion"] = lambda: judge_legs(subject, subject.images["locomotion"])
    return judges
