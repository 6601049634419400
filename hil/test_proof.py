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


@pytest.mark.hil_req("DECISIONS")
def test_a_sample_of_the_cells_agrees(
    hil_subject: Subject, hil_config: Any, hil_judge: Judge, hil_evidence: Evidence
) -> None:
    proof = prove(hil_subject, SAMPLED_CELLS, hil_config.seed)
    hil_evidence.proof(proof)
    hil_judge(proof.trial())
    assert proof.tried == min(SAMPLED_CELLS, proof.cells)


@pytest.mark.hil_req("SPACE")
def test_the_image_decides_as_the_simulator(
    hil_subject: Subject, hil_config: Any, hil_judge: Judge, hil_evidence: Evidence
) -> None:
    if hil_config.level != Level.EXHAUSTIVE:
        pytest.skip("a proof takes all cells: --hil-level exhaustive")
    proof = prove(hil_subject)
    hil_evidence.proof(proof)
    hil_judge(proof.trial())
    assert proof.proven
