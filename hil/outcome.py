"""What came of all trials of one robot."""

from collections.abc import Iterable
from dataclasses import dataclass, field

from hil.equivalence import Explain, Finding, Trial, Verdict, worst
from hil.evidence import Evidence
from hil.stimuli import Level
from hil.subject import Subject
from hil.target import Observation
from hil.traces import Replay


def finding_lines(small: Finding, subject: Subject) -> list[str]:
    """Return what a difference is, for a terminal: reading, both answers, lines of PBASIC."""
    lines = [f"smallest reading: {small.stimulus.text()}"] if small.stimulus else []
    lines += [f"expected: {_told(small.expected, subject)}"]
    lines += [f"{small.by}: {_told(small.observed, subject)}"]
    where = "decided in" if small.observed else "ends in"
    return [*lines, *(f"{where} {line}" for line in small.lines)]


def _told(seen: Observation | None, subject: Subject) -> str:
    """Return a decision in words; of one in a trace as much as is there."""
    words = [] if seen is None or seen.state is None else [f"state {seen.state}"]
    if seen is not None and seen.command >= 0:
        words.append(f"command {seen.command} {subject.movement(seen.command)}")
    return ", ".join(words) or "no decision"


@dataclass
class Report:
    """What came of all trials of a robot.

    Attributes:
        subject: what was tried.
        level: how much.
        seed: of what was chosen by chance.
        trials: by what they are called.
        explain: names lines of PBASIC; None where the image is not the source's.
        evidence: the same and more, for a page.
    """

    subject: Subject
    level: Level
    seed: int
    trials: dict[str, Trial] = field(default_factory=dict)
    explain: Explain | None = None

    def __post_init__(self) -> None:
        self.evidence = Evidence(self.subject)

    def add(self, name: str, trial: Trial) -> None:
        """Note a trial."""
        self.trials[name] = trial
        self.evidence.trial(name, trial)

    def add_all(self, rows: Iterable[tuple[str, Trial]]) -> None:
        """Note several trials, each with its name."""
        for name, trial in rows:
            self.add(name, trial)

    @property
    def verdict(self) -> Verdict:
        """What they come to."""
        return worst(trial.verdict for trial in self.trials.values())

    @property
    def from_trace(self) -> bool:
        """Whether the smallest stimulus comes from a trace, and from nothing else."""
        found = [trial for trial in self.trials.values() if trial.smallest]
        return bool(found) and all(isinstance(trial, Replay) for trial in found)

    @property
    def smallest(self) -> Finding | None:
        """The smallest stimulus that shows a fault, of all trials."""
        found = [trial.smallest for trial in self.trials.values() if trial.smallest]
        return next((one for one in found if one.stimulus), found[0] if found else None)
