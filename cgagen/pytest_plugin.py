"""The pytest plugin of cgagen: firmware on trial, in this project and in anybody's.

It comes with the package, so it is loaded in every run of pytest on a machine that has cgagen.
Therefore it imports nothing of cgagen before a test asks for one of its fixtures, and all its
words begin with `hil`.

Fixtures: `hil_config` (what was asked for), `hil_subject` (robot, genome, images), `hil_target`
(open, identity checked), `hil_registers` (the emulator from a snapshot behind sensing),
`hil_oracle` (the simulator), `hil_stimuli` (readings of the level), `hil_check` (compares, fails
with a report). Markers: `hil_needs(CAPABILITY, ...)` and `hil_hardware`.

The order for every option: command line, ini file, environment.
"""

import importlib
import importlib.util
import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from hil.equivalence import Trial
    from hil.registers import RegisterTarget
    from hil.simulated import SimulatedTarget
    from hil.stimuli import Level
    from hil.subject import Subject
    from hil.target import Stimulus, Target

EMULATOR = "emulator"
LEVELS = ("smoke", "boundary")
ROLES = ("predator", "prey")
REFERENCE = Path("firmware")
"""Folder of the reference builds, beside `hil/` in a checkout of cgagen."""

_REPORTS = pytest.StashKey[list[str]]()


@dataclass(frozen=True, slots=True)
class HilConfig:
    """What was asked for.

    Attributes:
        targets: URLs: `emulator`, `serial:PORT`, `can:INTERFACE:CHANNEL`.
        genome: a genome's file, or None for the reference.
        robot: a robot's name or file, or None.
        build: a build folder, or None.
        level: `smoke` or `boundary`.
        seed: for what is chosen by chance.
        require: what cannot be tried is an error, not a skip.
    """

    targets: tuple[str, ...]
    genome: str | None
    robot: str | None
    build: str | None
    level: str
    seed: int
    require: bool


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the options, all of them prefixed."""
    group = parser.getgroup("hil", "firmware of cgagen on trial")
    group.addoption(
        "--hil-target",
        action="append",
        metavar="URL",
        help="emulator (default), serial:PORT or can:INTERFACE:CHANNEL; may be repeated.",
    )
    group.addoption("--hil-genome", metavar="FILE", help="Genome to build and try.")
    group.addoption("--hil-robot", metavar="NAME|FILE", help="Robot to build and try.")
    group.addoption("--hil-build", metavar="DIR", help="Build folder to try as it is.")
    group.addoption("--hil-level", choices=LEVELS, help="How much is tried (smoke).")
    group.addoption("--hil-seed", type=int, help="For what is chosen by chance (1).")
    group.addoption(
        "--hil-require", action="store_true", help="What a target cannot do is an error, no skip."
    )
    parser.addini("hil_target", "targets of the firmware's tests", type="args", default=[])
    for name in ("genome", "robot", "build", "level", "seed"):
        parser.addini(f"hil_{name}", f"as --hil-{name}", default="")


def pytest_configure(config: pytest.Config) -> None:
    """Make the markers known."""
    config.addinivalue_line("markers", "hil_needs(cap, ...): a target must be able to do this")
    config.addinivalue_line("markers", "hil_hardware: only for a target that is named")
    config.stash[_REPORTS] = []
    own = [_given(config, name) for name in ("genome", "robot", "build")]
    subjects = ("named",) if any(own) else ROLES
    config.pluginmanager.register(_fixtures_of(subjects, _targets(config)), "cgagen-hil")


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_call(item: pytest.Item) -> None:
    """Skip what a target cannot do, or refuse, where that was asked for."""
    for mark in item.iter_markers("hil_needs"):
        target: Target = getattr(item, "funcargs", {})["hil_target"]
        missing = [one for one in mark.args if one not in target.caps]
        if missing:
            words = f"{target.url} cannot show: {', '.join(missing)}"
            if item.config.getoption("--hil-require"):
                pytest.fail(words, pytrace=False)
            pytest.skip(words)


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """Leave hardware alone that was not named."""
    if next(item.iter_markers("hil_hardware"), None) and _targets(item.config) == (EMULATOR,):
        pytest.skip("needs a target on a wire; name one with --hil-target")


def pytest_terminal_summary(terminalreporter: Any, config: pytest.Config) -> None:
    """Say what was tried."""
    lines = config.stash.get(_REPORTS, [])
    if lines:
        terminalreporter.section("firmware on trial")
        for line in lines:
            terminalreporter.write_line(line)


@pytest.fixture(scope="session")
def hil_config(pytestconfig: pytest.Config) -> HilConfig:
    """Return what was asked for."""
    return _config(pytestconfig)


@pytest.fixture(scope="session")
def hil_oracle(hil_subject: "Subject") -> "SimulatedTarget":
    """Return the simulator: what every target is compared with."""
    oracle: SimulatedTarget = _import("hil.simulated").SimulatedTarget(hil_subject)
    return oracle


@pytest.fixture(scope="session")
def hil_registers(hil_subject: "Subject") -> Iterator["RegisterTarget"]:
    """Return the emulator from a snapshot behind sensing: thousands of decisions a second."""
    compile_source = _import("cgagen.tokenizer").compile_source
    target = _import("hil.registers").RegisterTarget(hil_subject, compile_source)
    with target:
        yield target


@pytest.fixture(scope="session")
def hil_stimuli(hil_subject: "Subject", hil_config: HilConfig) -> "list[Stimulus]":
    """Return the readings of the level asked for."""
    stimuli = _import("hil.stimuli")
    level: Level = stimuli.Level(hil_config.level)
    found: list[Stimulus] = stimuli.stimuli_of(hil_subject.robot, level, hil_config.seed)
    return found


@pytest.fixture
def hil_check(
    request: pytest.FixtureRequest, hil_subject: "Subject", hil_config: HilConfig
) -> "Callable[[Target, Sequence[Stimulus]], Trial]":
    """Return what applies readings to a target and fails with a report where it must."""
    equivalence, verify = _import("hil.equivalence"), _import("hil.verify")

    def check(target: "Target", stimuli: "Sequence[Stimulus]") -> "Trial":
        explain = verify.explainer(hil_subject, target) if hasattr(target, "trace") else None
        trial: Trial = equivalence.compare(hil_subject, target, stimuli, explain)
        request.node.user_properties += [
            ("hil_target", trial.target),
            ("hil_verdict", str(trial.verdict)),
            ("hil_decisions", trial.decisions),
            ("hil_image", hil_subject.images["main"].digest),
            ("hil_genome", hil_subject.genome_digest),
            ("hil_seed", hil_config.seed),
        ]
        _report(request.config, hil_subject, hil_config, trial)
        return trial

    return check


def _fixtures_of(subjects: tuple[str, ...], targets: tuple[str, ...]) -> object:
    """Return the fixtures whose parameters depend on what was asked for.

    As fixtures with parameters they give way to a fixture of the same name in a test's own file.
    """

    @pytest.fixture(scope="session", params=subjects)
    def hil_subject(request: pytest.FixtureRequest, hil_config: HilConfig) -> Any:
        """Return what is on trial: the reference predator and prey, or what was named."""
        return _subject(hil_config, request.param)

    @pytest.fixture(scope="session", params=targets)
    def hil_target(request: pytest.FixtureRequest, hil_subject: Any) -> Iterator[Any]:
        """Return a target of the command line, open; absent, it is an error."""
        target = _import("hil.targets").make_target(request.param, hil_subject)
        try:
            target.open()
            yield target
        finally:
            target.close()

    holder = ModuleType("cgagen-hil")  # pytest looks for fixtures in modules and classes
    holder.__dict__.update(hil_subject=hil_subject, hil_target=hil_target)
    return holder


def _subject(asked: HilConfig, role: str) -> "Subject":
    reading = _import("hil.subject")
    subject: Subject
    if asked.build:
        subject = reading.read_subject(Path(asked.build))
        return subject
    if asked.genome or asked.robot:
        return _built(asked)
    folder = Path(reading.__file__).parent.parent / REFERENCE / role
    if not folder.is_dir():
        raise pytest.UsageError(
            "no firmware was named; give --hil-genome FILE, --hil-robot NAME or --hil-build DIR"
        )
    subject = reading.read_subject(folder)
    return subject


def _report(config: pytest.Config, subject: "Subject", asked: HilConfig, trial: "Trial") -> None:
    """Note what was tried; fail the test where the verdict is not PASS."""
    image = subject.images["main"].digest[:8]
    config.stash[_REPORTS].append(
        f"{trial.verdict} {subject.robot.name} on {trial.target}: {trial.decisions} decisions, "
        f"level {asked.level}, seed {asked.seed}, image {image}, genome {subject.genome_digest}"
        + (f", {trial.stale} stale" if trial.stale else "")
        + (f", {trial.left_out} left out" if trial.left_out else "")
        + (f"; {trial.note}" if trial.note else "")
    )
    if trial.verdict == "PASS":
        return
    lines = [f"{trial.verdict}: {trial.reason}"]
    if trial.smallest is not None and trial.smallest.stimulus is not None:
        lines += [f"smallest reading: {trial.smallest.stimulus.text()}"]
        lines += [str(line) for line in trial.smallest.lines]
    pytest.fail("\n".join(lines), pytrace=False)


def _given(config: pytest.Config, name: str) -> str:
    """Return an option by the command line, the ini file or the environment; "" for none."""
    option = config.getoption(f"--hil-{name}", None)
    if option is not None:
        return str(option)
    return config.getini(f"hil_{name}") or os.environ.get(f"CGAGEN_HIL_{name.upper()}", "")


def _targets(config: pytest.Config) -> tuple[str, ...]:
    """Return the targets that were named, each once; the emulator where none was."""
    named = config.getoption("--hil-target", None) or config.getini("hil_target")
    named = named or os.environ.get("CGAGEN_HIL_TARGET", "").split() or [EMULATOR]
    return tuple(dict.fromkeys(named))


def _config(config: pytest.Config) -> HilConfig:
    level, seed = _given(config, "level") or LEVELS[0], _given(config, "seed") or "1"
    if level not in LEVELS or not seed.isdigit():
        raise pytest.UsageError(
            f"hil: level {level} and seed {seed}; the level is one of {', '.join(LEVELS)}, the "
            "seed a number"
        )
    return HilConfig(
        _targets(config),
        _given(config, "genome") or None,
        _given(config, "robot") or None,
        _given(config, "build") or None,
        level,
        int(seed),
        bool(config.getoption("--hil-require", False)),
    )


def _built(asked: HilConfig) -> "Subject":
    """Return the firmware of a genome and a robot, built now."""
    load, robots = _import("cgagen.genome").load, _import("cgagen.robot")
    genome = load(Path(asked.genome)) if asked.genome else None
    robot = robots.load_robot(asked.robot or (genome.robot if genome else ""))
    with _import("cgagen.tokenizer").Tokenizer() as tokenizer:
        build = _import("cgagen.build").make_build(robot, genome, tokenizer)
    subject: Subject = _import("hil.subject").subject_of(build, asked.genome or robot.name)
    return subject


def _import(name: str) -> Any:
    """Import a module of ours, or say which folder is in the place of hil/ or sim/."""
    for room in ("hil", "sim"):
        spec = importlib.util.find_spec(room)
        ours = Path(__file__).parent.parent / room
        if spec is None or not spec.origin or Path(spec.origin).parent.resolve() != ours.resolve():
            raise pytest.UsageError(
                f"cgagen's {name} cannot be imported: a folder {room}/ of your own hides ours, so "
                "rename it, or run pytest from elsewhere"
            )
    return importlib.import_module(name)
