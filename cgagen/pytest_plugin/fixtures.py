"""The fixtures. All names begin with `hil`; whatever they need of cgagen is imported in them."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, NoReturn

import pytest

from cgagen.pytest_plugin.artifacts import FILES, Draw
from cgagen.pytest_plugin.options import EXHAUSTIVE, HilConfig, on_wire
from cgagen.pytest_plugin.ours import errors, load, subject_for
from cgagen.pytest_plugin.session import SESSION, UNPROVEN, VERDICT
from cgagen.pytest_plugin.wires import note_left_open, shown

if TYPE_CHECKING:
    from cgagen.stamp.image import Image
    from hil.equivalence import Trial
    from hil.evidence import Evidence
    from hil.registers import RegisterTarget
    from hil.simulated import SimulatedTarget
    from hil.stimuli import Level
    from hil.subject import Subject
    from hil.target import Stimulus, Target
    from hil.traces import Trace

BESIDE = ("proof", "sources", "emulator:locomotion", "emulator:timing", "emulator:conduct")
"""Targets of the trials that a test of decisions has besides its own."""

Judge = Callable[["Trial"], "Trial"]
Check = Callable[["Target", "Sequence[Stimulus] | Trace"], "Trial"]


@pytest.fixture(scope="session")
def hil_config(pytestconfig: pytest.Config) -> HilConfig:
    """Return what was asked for."""
    return pytestconfig.stash[SESSION].asked


@pytest.fixture(scope="session")
def hil_oracle(hil_subject: "Subject") -> "SimulatedTarget":
    """Return the simulator: what every target is compared with."""
    oracle: SimulatedTarget = load("hil.simulated").SimulatedTarget(hil_subject)
    return oracle


@pytest.fixture(scope="session")
def hil_image(hil_subject: "Subject") -> "dict[str, Image]":
    """Return the images that are to be in the chips, by chip."""
    return hil_subject.images


@pytest.fixture(scope="session")
def hil_registers(hil_subject: "Subject") -> Iterator["RegisterTarget"]:
    """Return the emulator from a snapshot behind sensing: thousands of decisions a second."""
    compile_source = load("cgagen.tokenizer").compile_source
    target = load("hil.registers").RegisterTarget(hil_subject, compile_source)
    with target:
        yield target


@pytest.fixture(scope="session")
def hil_stimuli(hil_subject: "Subject", hil_config: HilConfig) -> "list[Stimulus]":
    """Return the readings of the level asked for.

    At the exhaustive level `hil_check` proves the image for every reading besides, so a target is
    given only those by which its pins, or a wire, could go wrong: on real hardware a minute.
    """
    stimuli = load("hil.stimuli")
    level: Level = stimuli.Level(hil_config.level)
    if level is stimuli.Level.EXHAUSTIVE:
        proving: list[Stimulus] = load("hil.verify").pin_readings(
            hil_subject, level, hil_config.seed
        )
        return proving
    found: list[Stimulus] = stimuli.stimuli_of(hil_subject.robot, level, hil_config.seed)
    return found


@pytest.fixture
def hil_evidence(request: pytest.FixtureRequest, hil_subject: "Subject") -> "Evidence":
    """Return what the report will say of the firmware; a test may add to it."""
    return request.config.stash[SESSION].evidence(hil_subject)


@pytest.fixture
def hil_judge(
    request: pytest.FixtureRequest, hil_subject: "Subject", hil_config: HilConfig
) -> Judge:
    """Return what notes a trial in the report, and fails the test where it is not PASS."""
    session = request.config.stash[SESSION]

    def judge(trial: "Trial") -> "Trial":
        named = replace(trial, target=shown(trial.target, hil_config.targets))
        name = " ".join([request.node.nodeid, *_which(trial, hil_config.legs)])
        session.note(name, hil_subject, named)
        request.node.user_properties += [
            ("hil_target", named.target),
            (VERDICT, str(trial.verdict)),
            ("hil_decisions", trial.decisions),
            ("hil_image", hil_subject.images["main"].digest),
            ("hil_genome", hil_subject.origin_digest),
            ("hil_robot", hil_subject.robot.digest),
            ("hil_seed", hil_config.seed),
        ]
        left = session.evidence(hil_subject).not_tried if trial.target in hil_config.targets else {}
        request.node.user_properties += [
            ("hil_not_tried", f"{row}: {why}") for row, why in left.items()
        ]
        if trial.verdict != "PASS":
            again = session.again(request.node.nodeid)
            pytest.fail(_words(trial, hil_subject, again), pytrace=False)
        return trial

    return judge


@pytest.fixture
def hil_check(
    hil_subject: "Subject",
    hil_config: HilConfig,
    hil_evidence: "Evidence",
    hil_judge: Judge,
    hil_stimuli: "list[Stimulus]",
) -> Check:
    """Return what applies readings or a trace to a target and fails with a report where it must.

    With `hil_stimuli`, what `cgagen verify` tries of both images besides is tried on the emulator,
    too, once for all tests: sources, movements, timing, conduct, and at the exhaustive level the
    proof; and the locomotion controller of `--hil-legs` walks. What a sick bench has blocked is
    repeated as often as `--hil-reruns` says, after a reset.
    """

    def once(target: "Target", stimuli: "Sequence[Stimulus] | Trace") -> "Trial":
        explainers = load("hil.explainers")
        explain = (
            explainers.explainer(hil_subject, target)
            if hasattr(target, "trace")
            else explainers.explainer_elsewhere(
                hil_subject, load("cgagen.tokenizer").compile_source
            )
        )
        trial: Trial
        if hasattr(stimuli, "samples"):
            trial = load("hil.traces").replay(hil_subject, target, stimuli, explain)
        else:
            compare, ear = (
                load("hil.equivalence").compare,
                hil_evidence.ear(shown(target.url, hil_config.targets)),
            )
            trial = compare(hil_subject, target, stimuli, explain, ear)
        return trial

    def check(target: "Target", stimuli: "Sequence[Stimulus] | Trace") -> "Trial":
        trial = once(target, stimuli)
        for _ in range(hil_config.reruns):
            if trial.verdict != "BLOCKED":
                break
            reset(target)
            trial = once(target, stimuli)
        trial = hil_judge(trial)
        if stimuli is hil_stimuli:
            compile_source = load("cgagen.tokenizer").compile_source
            if hil_config.level == EXHAUSTIVE:
                proof = load("hil.proving").whole_proof(hil_evidence, compile_source)
                hil_judge(proof.trial())
            beside = load("hil.beside")
            for other in beside.beside_decisions(hil_evidence, compile_source):
                hil_judge(other)
            if hil_config.legs and target.url in hil_config.targets and on_wire(target.url):
                hil_evidence.trial(beside.LEGS, beside.walked(hil_evidence, hil_config.legs))
                hil_judge(beside.walked(hil_evidence, hil_config.legs))
        return trial

    return check


@pytest.fixture
def hil_artifacts(request: pytest.FixtureRequest) -> Path:
    """Return the test's folder for what it wants to leave behind."""
    return request.node.stash[FILES].folder()  # type: ignore[no-any-return]


@pytest.fixture
def hil_vcd(request: pytest.FixtureRequest) -> Draw:
    """Return what draws the wires of a bench of the test's own, as `--hil-vcd` says."""
    return request.node.stash[FILES].record  # type: ignore[no-any-return]


@pytest.fixture
def hil_trace(request: pytest.FixtureRequest, hil_subject: "Subject") -> "Trace":
    """Return a trace: of `--hil-trace`, or of the test's marker `hil_trace(FILE, ...)`."""
    return _trace(request, hil_subject, "a trace; name one with --hil-trace FILE")


@pytest.fixture
def hil_vectors(request: pytest.FixtureRequest, hil_subject: "Subject") -> "Trace":
    """Return readings written by hand: of the test's marker `hil_vectors(FILE.csv, ...)`."""
    return _trace(request, hil_subject, "vectors; name a CSV with --hil-trace or in the marker")


def _trace(request: pytest.FixtureRequest, subject: "Subject", wanted: str) -> "Trace":
    path: Path | None = getattr(request, "param", None)
    if path is None:
        missing(request.node, f"needs {wanted}")
    origin = load("hil.traces.sidecar").read_origin(path, str(path))
    if origin is not None and origin.role is not subject.role:
        pytest.skip(f"{path.name} is a {origin.role}'s, and {subject.robot.name} none")
    trace: Trace = load("hil.traces").read_trace(path, subject.robot)
    return trace


def fixtures_of(subjects: tuple[str, ...], targets: tuple[str, ...]) -> object:
    """Return the fixtures whose parameters depend on what was asked for.

    As fixtures with parameters they give way to a fixture of the same name in a test's own file.
    """

    @pytest.fixture(scope="session", params=subjects)
    def hil_subject(request: pytest.FixtureRequest, hil_config: HilConfig) -> Any:
        """Return what is on trial: the reference predator and prey, or what was named."""
        return subject_for(hil_config, request.param)

    @pytest.fixture(scope="session", params=targets)
    def hil_target(
        request: pytest.FixtureRequest, hil_subject: Any, hil_config: HilConfig
    ) -> Iterator[Any]:
        """Return a target of the command line, open; absent, it is an error."""
        opening = load("hil.opening").open_target
        target = opening(request.param, hil_subject, hil_config.flash, hil_config.reruns)
        try:
            if on_wire(request.param):
                note_left_open(request, hil_subject, target, hil_config)
            yield target
        finally:
            target.close()

    holder = ModuleType("cgagen-hil")  # pytest looks for fixtures in modules and classes
    holder.__dict__.update(hil_subject=hil_subject, hil_target=hil_target)
    return holder


def _words(trial: "Trial", subject: "Subject", again: str) -> str:
    """Return why a trial is not PASS, and how to see it again."""
    small = trial.smallest
    told = load("hil.outcome").finding_lines(small, subject) if small else []
    return "\n".join([f"{trial.verdict}: {trial.reason}", *told, f"again: {again}"])


def _which(trial: "Trial", legs: str | None) -> list[str]:
    """Return which of a test's trials it is: a replayed file, or what is tried beside decisions."""
    name: str = getattr(trial, "trace", "")
    if trial.target == legs:
        return ["legs"]
    return [Path(name).name] if name else [trial.target] if trial.target in BESIDE else []


def reset(target: "Target") -> None:
    """Reset a sick target, if it can be; what follows will tell."""
    with suppress(errors().RigError):
        target.reset()


def blocked(error: BaseException, sets_up: bool = False) -> bool:
    """Whether an error says nothing of the firmware: the bench is sick, or was never set up."""
    known = errors()
    sick = isinstance(error, known.RigError) or (sets_up and is_a_sentence(error))
    return sick and not isinstance(error, known.TargetTimeout)


def missing(item: pytest.Item, words: str) -> NoReturn:
    """Skip a test for which something is missing; with `--hil-require` it is an error."""
    if item.config.stash[SESSION].asked.require:
        item.user_properties.append((VERDICT, UNPROVEN))
        pytest.fail(words, pytrace=False)
    pytest.skip(words)


def is_a_sentence(error: BaseException) -> bool:
    """Whether the words of an error say all that its reader needs."""
    return isinstance(error, errors().CgagenError | pytest.UsageError)
