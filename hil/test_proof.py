"""The whole sensor space of the main controller on trial, cell by cell.

A sample of the cells always, all of them with `--hil-level exhaustive`.
"""

from collections.abc import Callable
from typing import Any

import pytest

from hil.equivalence import Trial
from hil.evidence import Evidence
from hil.proof import prove
from hil.stimuli import Level
from hil.subject import Subject
from hil.verify import SAMPLED_CELLS

Judge = Callable[[Trial], Trial]


SPACE = pytest.mark.hil_req("SPACE")
"""Only all of the cells stand for the whole space."""


@pytest.mark.hil_req("DECISIONS")
def test_the_image_decides_as_the_simulator(
    request: pytest.FixtureRequest,
    hil_subject: Subject,
    hil_config: Any,
    hil_judge: Judge,
    hil_evidence: Evidence,
) -> None:
    """By a sample of the cells, or by all of them."""
    whole = hil_config.level == Level.EXHAUSTIVE
    if whole:
        request.node.user_properties += [(SPACE.name, str(one)) for one in SPACE.args]
    proof = prove(hil_subject, None if whole else SAMPLED_CELLS, hil_config.seed)
    hil_evidence.proof(proof)
    hil_judge(proof.trial())
    assert proof.tried == (proof.cells if whole else min(SAMPLED_CELLS, proof.cells))
