"""What a test of decisions leaves open: the other program, the lines, and chips beside a wire."""

from collections.abc import Callable, Iterator, Sequence

from hil import untried
from hil.conduct import try_conduct
from hil.equivalence import Trial
from hil.evidence import Evidence
from hil.registers import Compile
from hil.target import Target
from hil.timing import try_timing
from hil.verify import try_sources
from hil.walks import try_walks
from hil.wired import SERIAL, SERIAL_RESET
from hil.wired_walks import try_legs

LEGS = "legs"


def beside_decisions(evidence: Evidence, compile_source: Compile) -> Iterator[Trial]:
    """Try what `cgagen verify` tries of both images besides decisions, once for all tests.

    A build may hold the right main controller and another robot's locomotion controller; no
    decision shows it.

    Args:
        evidence: of the firmware; keeps what was tried.
        compile_source: the tokenizer.
    """
    subject, known = evidence.subject, evidence.beside

    def timed() -> Trial:
        trial, evidence.timing = try_timing(subject)
        return trial

    trials: tuple[tuple[str, Callable[[], Trial]], ...] = (
        ("sources", lambda: try_sources(subject, compile_source)),
        ("movements", lambda: try_walks(subject)),
        ("timing", timed),
        ("conduct", lambda: try_conduct(subject)),
    )
    for name, make in trials:
        if name not in known:
            known[name] = make()
        yield known[name]


def walked(evidence: Evidence, url: str) -> Trial:
    """Have the locomotion controller on a port walk, once for all tests. See `try_legs`."""
    if LEGS not in evidence.beside:
        evidence.beside[LEGS] = try_legs(url, evidence.subject)
    return evidence.beside[LEGS]


def left_open(
    target: Target, named: Sequence[str], legs: str | None
) -> Iterator[tuple[str, Trial]]:
    """Return the rows of chips that an open target on a wire does not show.

    Args:
        target: it.
        named: all targets of the run; a cable to the main controller shows its bytes.
        legs: the locomotion controller's port; None where none was named.
    """
    read = any(untried.kind_of(url) in (SERIAL, SERIAL_RESET) for url in named)
    for name, trial in untried.of_wires([target], legs):
        if name == LEGS or not read:
            yield name, trial
