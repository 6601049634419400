"""The options of the plugin: one table, and the order command line, ini file, environment."""

import os
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import pytest

from cgagen.notations import small_number
from cgagen.shown import short
from cgagen.together import Needs, trouble

EMULATOR, SIMULATOR = "emulator", "simulator"
LEVELS = SMOKE, _, EXHAUSTIVE = ("smoke", "boundary", "exhaustive")
VCD = OFF, FAIL, ALWAYS = ("off", "fail", "always")
FLASH = AUTO, _, NEVER = ("auto", "always", "never")
ARTIFACTS = "hil-artifacts"
"""Where waveforms go when no other folder is named."""


class Option(NamedTuple):
    """One option.

    Attributes:
        name: `--hil-NAME`, ini `hil_NAME`, environment `CGAGEN_HIL_NAME`.
        words: what it takes; "" for a switch.
        told: for `--help`.
        many: may be repeated; in the ini file and the environment, words between blanks.
        choices: what it may be; () for anything. The first is the default.
        path: in the ini file, it is meant from the folder of that file.
    """

    name: str
    words: str
    told: str
    many: bool = False
    choices: tuple[str, ...] = ()
    path: bool = False


LEVEL_TOLD = (
    "How much is tried (exhaustive: the image is proven on the emulator, for every reading, and "
    "each target is given every state, every threshold and 200 readings by chance)."
)

OPTIONS = (
    Option(
        "target", "URL", "emulator (default), simulator, serial[-reset]:PORT, can:...", many=True
    ),
    Option("genome", "FILE", "Genome to build and try.", path=True),
    Option("robot", "NAME|FILE", "Robot to build and try."),
    Option("build", "DIR", "Build folder to try; of the genome, robot named.", path=True),
    Option("legs", "URL", "Locomotion controller beside a target on a wire: serial[-reset]:PORT."),
    Option("level", "LEVEL", LEVEL_TOLD, choices=LEVELS),
    Option("seed", "N", "For what is chosen by chance (1)."),
    Option("trace", "FILE", "Trace for tests that ask for hil_trace.", many=True, path=True),
    Option("record", "DIR", "Write down every decision, as jsonl and as traces.", path=True),
    Option("vcd", "WHEN", "Waveforms of emulated benches, as artifacts (off).", choices=VCD),
    Option("coverage", "DIR|FILE", "Lines and branches of PBASIC, as LCOV and listing.", path=True),
    Option("flash", "WHEN", "Load serial targets when their image differs (auto).", choices=FLASH),
    Option("artifacts", "DIR", "A folder per test; always kept where it fails.", path=True),
    Option("report", "FILE", "FILE.json is data, FILE.html a page.", many=True, path=True),
    Option("kills", "FILE", "Kill matrix of make hil-mutants.", many=True, path=True),
    Option("requirements", "FILE", "TOML: what the ids of hil_req stand for.", path=True),
    Option("reruns", "N", "Repeat what a sick bench has blocked (0)."),
    Option("force", "", "Write over files that are not of ours."),
    Option("require", "", "What cannot be tried is an error, no skip."),
)

MARKERS = (
    "hil_needs(cap, ...): a target must be able to do this",
    "hil_hardware: only for a target that is named",
    "hil_req(id, ...): requirements that this test stands for",
    "hil_trace(file, ...): traces for the fixture hil_trace, beside the test's own file",
    "hil_vectors(file, ...): tables for the fixture hil_vectors, likewise",
    "hil_slow: minutes rather than seconds; runs when it is named, or by -m hil_slow",
)
"""What is said of a test; `pytest --markers` lists them."""

FIRMWARE = GENOME, ROBOT, BUILD = ("genome", "robot", "build")
"""Options that say what is on trial."""

SERIAL = "--hil-target serial:PORT"
CAN = "--hil-target can:..."

RULES: tuple[Needs, ...] = (
    Needs("--hil-kills", ("--hil-report",)),
    Needs("--hil-requirements", ("--hil-report",)),
    Needs("--hil-flash", (SERIAL,)),
    Needs("--hil-legs", (SERIAL, CAN)),
)
"""What has no effect without another one. Genome and robot beside a build are held together."""


@dataclass(frozen=True, slots=True)
class HilConfig:
    """What was asked for.

    Attributes:
        targets: URLs: `emulator`, `simulator`, `serial:PORT`, `serial-reset:PORT`, `can:...`.
        genome: a genome's file, or None for the reference.
        robot: a robot's name or file, or None.
        build: a build folder, or None.
        level: `smoke`, `boundary` or `exhaustive`.
        seed: for what is chosen by chance.
        require: what cannot be tried is an error, not a skip.
        traces: files for `hil_trace`.
        record: folder for decisions, or None.
        vcd: `off`, `fail` or `always`.
        coverage: folder or file, or None.
        flash: `auto`, `always` or `never`.
        artifacts: folder of one folder per test, or None.
        reports: files.
        kills: kill matrices.
        requirements: file, or None for those of cgagen's own tests.
        reruns: how often what is BLOCKED is repeated.
        force: files that are not of ours may be written over.
        legs: the locomotion controller's port, or None.
    """

    targets: tuple[str, ...]
    genome: str | None
    robot: str | None
    build: str | None
    level: str
    seed: int
    require: bool
    traces: tuple[Path, ...] = ()
    record: Path | None = None
    vcd: str = OFF
    coverage: Path | None = None
    flash: str = AUTO
    artifacts: Path | None = None
    reports: tuple[Path, ...] = ()
    kills: tuple[Path, ...] = ()
    requirements: Path | None = None
    reruns: int = 0
    force: bool = False
    legs: str | None = None

    @property
    def folder(self) -> Path | None:
        """Where artifacts go; None for nowhere."""
        return self.artifacts or (Path(ARTIFACTS) if self.vcd != OFF else None)

    @property
    def writes(self) -> bool:
        """Whether something is written at the end."""
        return self.coverage is not None or bool(self.reports)

    @property
    def counts(self) -> bool:
        """Whether executed lines are to be counted."""
        return self.coverage is not None or bool(self.reports)


def add_options(parser: pytest.Parser) -> None:
    """Add the options, all of them prefixed."""
    group = parser.getgroup("hil", "firmware of cgagen on trial")
    for one in OPTIONS:
        flag = f"--hil-{one.name}"
        if not one.words:
            group.addoption(flag, action="store_true", default=None, help=one.told)
        elif one.many:
            told = f"{one.told} May be repeated."
            group.addoption(flag, action="append", metavar=one.words, help=told)
        else:
            words = "|".join(one.choices) if one.choices else one.words
            group.addoption(flag, metavar=words, choices=one.choices or None, help=one.told)
        kind, default = ("args", list[str]()) if one.many else ("string", "")
        parser.addini(f"hil_{one.name}", f"as {flag}", type=kind, default=default)  # type: ignore[arg-type]


def given(config: pytest.Config, name: str) -> tuple[str, ...]:
    """Return the words of an option by the command line, the ini file or the environment."""
    one = next(option for option in OPTIONS if option.name == name)
    words = config.getoption(f"--hil-{name}", None)
    if words is not None:
        return tuple(words) if one.many else (str(words),)
    words = config.getini(f"hil_{name}")
    if words:
        found = tuple(words) if one.many else (str(words),)
        return tuple(str(config.rootpath / word) for word in found) if one.path else found
    words = os.environ.get(f"CGAGEN_HIL_{name.upper()}", "")
    return tuple(words.split()) if one.many else ((words,) if words else ())


def in_ini_file(config: pytest.Config, name: str) -> bool:
    """Whether an option has its words from the ini file."""
    return config.getoption(f"--hil-{name}", None) is None and bool(config.getini(f"hil_{name}"))


def on_command_line(config: pytest.Config) -> bool:
    """Whether an option of ours is on the command line: then the user means us."""
    return any(config.getoption(f"--hil-{one.name}", None) is not None for one in OPTIONS)


def targets_of(config: pytest.Config) -> tuple[str, ...]:
    """Return the targets that were named, each once; the emulator where none was."""
    return tuple(dict.fromkeys(given(config, "target"))) or (EMULATOR,)


def on_wires(config: pytest.Config) -> bool:
    """Whether a target was named that is no program."""
    return any(map(on_wire, targets_of(config)))


def on_wire(url: str) -> bool:
    """Whether a target is no program."""
    return url not in (EMULATOR, SIMULATOR)


def refuse_without_effect(config: pytest.Config) -> None:
    """Refuse what was typed and has no effect; the ini file and the environment are for many runs.

    Raises:
        pytest.UsageError: the first rule that is broken.
    """
    flags = {f"--hil-{one.name}": one.name for one in OPTIONS}
    typed = {flag for flag in flags if config.getoption(flag, None) is not None}
    there = {flag for flag, name in flags.items() if given(config, name)}
    there |= {SERIAL for url in targets_of(config) if url.startswith("serial")}
    there |= {CAN for url in targets_of(config) if url.startswith("can")}
    words = trouble((rule for rule in RULES if rule.option in typed), there)
    if words:
        raise pytest.UsageError(words)


def asked(config: pytest.Config) -> HilConfig:
    """Return what was asked for.

    Raises:
        pytest.UsageError: the ini file or the environment has a word that an option cannot be.
    """
    words = {one.name: given(config, one.name) for one in OPTIONS}
    one = {name: found[0] if found else None for name, found in words.items()}
    for option in OPTIONS:
        word = one[option.name]
        if option.choices and word is not None and word not in option.choices:
            raise pytest.UsageError(
                f"hil: {option.name} is {word}; the {option.name} is one of "
                + ", ".join(option.choices)
            )
    return HilConfig(
        targets=targets_of(config),
        genome=one["genome"],
        robot=one["robot"],
        build=one["build"],
        level=one["level"] or EXHAUSTIVE,
        seed=_number("seed", one["seed"], 1),
        require=_switch(one["require"]),
        traces=tuple(map(Path, words["trace"])),
        record=_path(one["record"]),
        vcd=one["vcd"] or OFF,
        coverage=_path(one["coverage"]),
        flash=one["flash"] or AUTO,
        artifacts=_path(one["artifacts"]),
        reports=tuple(map(Path, words["report"])),
        kills=tuple(map(Path, words["kills"])),
        requirements=_path(one["requirements"]),
        reruns=_number("reruns", one["reruns"], 0),
        force=_switch(one["force"]),
        legs=one["legs"],
    )


def _switch(word: str | None) -> bool:
    return (word or "").lower() in ("true", "1", "yes", "on")


def _path(word: str | None) -> Path | None:
    return Path(word) if word else None


def _number(name: str, word: str | None, default: int) -> int:
    if word is None:
        return default
    number = small_number(word)
    if number is None:
        raise pytest.UsageError(
            f"hil: {name} is {short(word)}; it is a number from 0, of up to 18 digits"
        )
    return number
