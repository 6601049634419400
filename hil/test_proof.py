"""The whole sensor space of the main controller on trial, cell by cell.

All of them, which is a proof; a sample with `--hil-level smoke` or `boundary`.
"""

from collections.abc import Callable
from typing import Any

import pytest

from cgagen.tokenizer import compile_source
from hil.equivalence import Trial
from hil.evidence import Evidence
from hil.proving import proof_of, whole_proof
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
    """By all of the cells, or by a sample of them."""
    whole = hil_config.level == Level.EXHAUSTIVE
    if whole:
        request.node.user_properties += [(SPACE.name, str(one)) for one in SPACE.args]
        proof = whole_proof(hil_evidence, compile_source)
    else:
        proof = proof_of(hil_subject, compile_source, SAMPLED_CELLS, hil_config.seed)
    hil_evidence.proof(proof)
    hil_judge(proof.trial())
    assert proof.tried == (proof.cells if whole else min(SAMPLED_CELLS, proof.cells))
