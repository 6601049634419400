"""All checks of a main controller, in the order in which they run: by pins and by words."""

from itertools import pairwise

from cgagen.bench_protocol import LISTEN_MS, MAIN_SLICE_MS, Banner, banner_text
from cgagen.emulator.chip import Coverage
from cgagen.stamp.compiled import Compiled
from hil.layout import layout_of
from hil.main_bench import late_hello, speaks
from hil.main_decides import decisions, genes
from hil.main_hunts import hunts
from hil.main_trial import MainTrial
from hil.main_wanted import Wanted
from hil.stimuli import neutral
from hil.subject import Subject
from hil.trial import BYTE_NS, MS, want

FAST_SLACK_NS, SLOW_SLACK_NS = 1_000_000, 4_000_000
"""What instructions between two waits may take. Choice: a little more than they do."""


def judge_main(
    subject: Subject, wanted: Wanted, compiled: Compiled, coverage: Coverage | None = None
) -> None:
    """Try a main controller.

    Raises:
        FailedCheck: by the first check that finds something.
        CgagenError: what it does is impossible on the bench.
    """
    trial = MainTrial(subject, compiled.image, coverage)
    trial.present(wanted.hunts[0][0])
    _start(trial)
    before, seen = trial.bench.snapshot(), len(trial.edges)
    decisions(trial, wanted, compiled)
    trial.bench.restore(before)
    if subject.genome is not None:
        genes(trial, compiled)
        trial.bench.restore(before)
    del trial.edges[seen:]
    hunts(trial, wanted, layout_of(compiled.source))
    trial = MainTrial(subject, compiled.image, coverage)
    trial.present(neutral(subject.robot))
    speaks(trial, wanted, compiled.image)
    late_hello(MainTrial(subject, compiled.image, coverage))


def _start(trial: MainTrial) -> None:
    """Banner and prompts, with no line touched; then the first look."""
    robot, subject = trial.robot, trial.subject
    lines, touched = trial.line_bits | trial.step_bit, list[int]()
    for pin in (pin for pin in range(16) if lines >> pin & 1):
        trial.bench.end(f"main.P{pin}").listen(
            lambda _level, pin=pin: touched.append(pin) if trial.drives >> pin & 1 else None  # type: ignore[misc]
        )
    want(trial.wait("look", 2_500), "hang", "never looks at its sensors")
    want(not touched, "handshake", "drives a line on its way to the first look")
    digest = subject.sources["main"].split("Source:  ")[1][:8]
    wanted = banner_text(Banner(1, "main", robot.name, subject.genome_digest, digest)) + "\r"
    want(trial.said.rstrip(">") == wanted, "banner", f"says {trial.said!r}")
    prompts = trial.heard_ns[len(wanted) :]
    slices = [b - a for a, b in pairwise([*prompts, trial.now_ns])]
    want(len(slices) > 1, "banner", "does not listen")
    least = MAIN_SLICE_MS * MS + BYTE_NS // 2
    slack = FAST_SLACK_NS if trial.fast else SLOW_SLACK_NS
    want(min(slices) >= least, "banner", "slices too short")
    want(max(slices) <= least + BYTE_NS + slack, "banner", "slices too long")
    whole = trial.now_ns - prompts[0]
    want(whole >= LISTEN_MS * MS, "banner", f"listens for {whole / MS:.0f} ms")
    want(whole - slices[0] < LISTEN_MS * MS + 20 * MS, "banner", f"listens {whole / MS:.0f} ms")
    want(not trial.drives & lines, "handshake", "drives a line before its first decision")
