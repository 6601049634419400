"""The settings of a run, and the text of `0-run.toml` that repeats them exactly."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

import tomli_w

from cgagen import files
from cgagen.errors import RunError
from cgagen.evolve import Settings
from cgagen.notations import parse_toml
from cgagen.run.streams import GENERATION_BITS, SEED_BITS, TRIAL_BITS
from cgagen.shown import short, shown
from cgagen.words import GENOME_BITS

FORMAT = "cgagen-run-1"

Option = str | int | float | bool
"""A value of the world's options; what it means is the world's business."""


@dataclass(frozen=True, slots=True)
class RunSettings:
    """Everything that decides the content of a run's files, but for the input files.

    Attributes:
        evolution: the genetic algorithm.
        generations: how many. Ref: S1 section IV.
        starts_per_generation: random starts, new for each generation, the same for all its
            individuals. Ref: S1 section III.A.
        steps: gait cycles of an episode. Ref: S1 section III.A.
        fixed_starts: starts that stay the same over the run. Ref: S1 section IV.
        fixed_starts_seed: theirs; not the run's seed, so that all runs share them (choice).
        evaluate_every: generations between two evaluations on the fixed starts; the first and
            the last are evaluated as well. Ref: S1 section II.C.
        populations_at: generations whose population is written; the last is as well. Ref: S1
            section II.C.
        seed: of all random numbers but the fixed starts.
        first_trial: number of the first trial; a trial depends on its number and on no other.
        trials: how many. Ref: S1 section IV runs five.
        world: the world's options, (name, value) sorted by name.

    Raises:
        ValueError: a value is outside what is allowed.
    """

    evolution: Settings = field(default_factory=Settings)
    generations: int = 300
    starts_per_generation: int = 10
    steps: int = 200
    fixed_starts: int = 100
    fixed_starts_seed: int = 0
    evaluate_every: int = 10
    populations_at: tuple[int, ...] = (1, 100, 300)
    seed: int = 1
    first_trial: int = 1
    trials: int = 1
    world: tuple[tuple[str, Option], ...] = ()

    def __post_init__(self) -> None:
        counts = ("starts_per_generation", "steps", "fixed_starts", "evaluate_every")
        limits = dict.fromkeys(counts, (1, 2**31)) | {
            "generations": (1, 2**GENERATION_BITS - 1),
            "first_trial": (1, 2**TRIAL_BITS - 1),
            "trials": (1, 2**TRIAL_BITS - self.first_trial),
            "seed": (0, 2**SEED_BITS - 1),
            "fixed_starts_seed": (0, 2**SEED_BITS - 1),
        }
        for name, (least, most) in limits.items():
            value = getattr(self, name)
            if not least <= value <= most:
                raise ValueError(f"{name} is {value}, it must be {least} to {most}")
        if self.evolution.bits != GENOME_BITS:
            raise ValueError(f"bits is {self.evolution.bits}, a genome has {GENOME_BITS}")
        if any(generation < 1 for generation in self.populations_at):
            raise ValueError(f"populations_at is {self.populations_at}, each must be 1 or more")

    def is_evaluated(self, generation: int) -> bool:
        """Whether a generation also runs from the fixed starts.

        >>> [g for g in range(1, 25) if RunSettings(generations=24).is_evaluated(g)]
        [1, 10, 20, 24]
        """
        return (
            generation in (1, self.generations)
            or generation % self.evaluate_every == 0
            or self.is_written(generation)
        )

    def is_written(self, generation: int) -> bool:
        """Whether the whole population of a generation is written to a file."""
        return generation == self.generations or generation in self.populations_at


@dataclass(frozen=True, slots=True)
class Inputs:
    """The files that a run depends on, as their exact texts, and whom the genome is for.

    Attributes:
        predator: text of the predator's file.
        prey: text of the prey's file.
        arena: text of the arena's file.
        robot: name of the robot whose genome evolves.
        interface: its sensors, situations and movements in one line.
        robot_digest: its digest.
    """

    predator: str
    prey: str
    arena: str
    robot: str
    interface: str
    robot_digest: str

    def texts(self) -> dict[str, str]:
        """Return the texts by the file names that they have in a run folder."""
        return {
            "1-predator.toml": self.predator,
            "1-prey.toml": self.prey,
            "1-arena.toml": self.arena,
        }


@dataclass(frozen=True, slots=True)
class RunRecord:
    """What a run folder must hold for the run to be repeated or continued.

    Attributes:
        settings: all parameters.
        inputs: the texts of the input files.
        versions: (program, version), sorted; "cgagen" is among them.
    """

    settings: RunSettings
    inputs: Inputs
    versions: tuple[tuple[str, str], ...]

    @property
    def text(self) -> str:
        """Content of `0-run.toml`."""
        return to_text(self)

    @property
    def digest(self) -> str:
        """SHA-256 of `0-run.toml`, which names the digests of all inputs."""
        return files.digest(self.text)


_TABLES: dict[str, tuple[str, ...]] = {
    "": ("seed", "first_trial", "trials"),
    "evolution": ("generations", "starts_per_generation"),
    "evaluation": ("fixed_starts", "fixed_starts_seed", "evaluate_every", "populations_at"),
    "world": ("steps",),
}
"""Which table of the file holds which setting; [evolution] has those of `Settings`, too."""

_GENOME = ("robot", "interface", "robot_digest")


def to_text(record: RunRecord) -> str:
    """Return the text of `0-run.toml`: the same record gives the same bytes."""
    settings = record.settings
    data: dict[str, Any] = {"format": FORMAT}
    for table, names in _TABLES.items():
        target = data.setdefault(table, {}) if table else data
        target.update({name: _plain(getattr(settings, name)) for name in names})
    algorithm = settings.evolution
    data["evolution"].update({f.name: getattr(algorithm, f.name) for f in fields(algorithm)})
    data["world"]["options"] = dict(sorted(settings.world))
    data["genome"] = {name: getattr(record.inputs, name) for name in _GENOME}
    data["inputs"] = {name: files.digest(text) for name, text in record.inputs.texts().items()}
    data["versions"] = dict(sorted(record.versions))
    return tomli_w.dumps(data)


def from_text(text: str, name: Path, read_input: Callable[[str], str]) -> RunRecord:
    """Return the record that a `0-run.toml` and the input files beside it hold.

    Args:
        text: content of `0-run.toml`.
        name: the file, for sentences.
        read_input: returns the text of an input file by its name.

    Raises:
        RunError: another format, a key or value that this version does not write, or an input
            file that is not the one the run began with.
    """
    try:
        data = parse_toml(text)
    except ValueError as error:
        raise RunError(f"{name}: is not TOML ({error}); put back the file as it was") from None
    if data.get("format") != FORMAT:
        raise RunError(
            f"{name}: format is {shown(data.get('format'))}, and this version reads {FORMAT!r}; "
            "continue the run with the version that began it, or start a new one"
        )
    try:
        record = _from_toml(data, read_input)
        digests = dict(data["inputs"])
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise _changed(name, str(error)) from None
    for file, input_text in record.inputs.texts().items():
        if files.digest(input_text) != digests.get(file):
            raise RunError(
                f"{name.parent / file}: is not the file that the run began with; put it back, or "
                "start a new run in another folder"
            )
    if to_text(record) != text:
        raise _changed(name, "it is not as it was written")
    return record


def _from_toml(data: Mapping[str, Any], read_input: Callable[[str], str]) -> RunRecord:
    """Return the record of a parsed file; a missing key is a KeyError."""
    values: dict[str, Any] = {}
    for table, names in _TABLES.items():
        source = data[table] if table else data
        values |= {key: source[key] for key in names}
    values["populations_at"] = tuple(values["populations_at"])
    algorithm = Settings(**{f.name: data["evolution"][f.name] for f in fields(Settings)})
    settings = RunSettings(
        evolution=algorithm, world=tuple(sorted(data["world"]["options"].items())), **values
    )
    inputs = Inputs(
        predator=read_input("1-predator.toml"),
        prey=read_input("1-prey.toml"),
        arena=read_input("1-arena.toml"),
        **{key: data["genome"][key] for key in _GENOME},
    )
    return RunRecord(settings, inputs, tuple(sorted(data["versions"].items())))


def _plain(value: Any) -> Any:
    """Return a value in the form that TOML can hold."""
    return list(value) if isinstance(value, tuple) else value


def _changed(name: Path, why: str) -> RunError:
    """Return the sentence for a record that somebody edited."""
    return RunError(
        f"{name}: has been changed since the run began ({short(why, 200)}); put it back, or start "
        "a new run with other settings in another folder"
    )
