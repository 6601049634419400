"""What a target was asked in a test, as a trace that every target can replay."""

from collections.abc import Sequence

from hil.decisions import Decision
from hil.subject import Subject
from hil.target import Target
from hil.traces.recording import STEP_NS, images_of, kind_of, origin_of
from hil.traces.values import Trace, sample_of


def trace_of(subject: Subject, target: Target, decisions: Sequence[Decision], seed: int) -> Trace:
    """Return decisions as a trace, one second apart.

    Args:
        subject: what has decided.
        target: where.
        decisions: one at least, in order.
        seed: of what was chosen by chance.
    """
    samples = tuple(
        sample_of(n * STEP_NS, one.stimulus, (n + 1) & 0xFFFF, one.observation)
        for n, one in enumerate(decisions)
    )
    images = images_of(subject, target)
    origin = origin_of(
        subject, kind_of(target.url), images=images, seed=seed, source={"test": True}
    )
    return Trace(target.url, samples, origin)
