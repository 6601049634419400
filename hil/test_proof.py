"""The proof over the whole sensor space, for the main controller on trial.

A sample of the cells by default, all of them with `--hil-level exhaustive`.
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


@pytest.mark.hil_req("SPACE")
def test_the_image_decides_as_the_simulator(
    hil_subject: Subject, hil_config: Any, hil_judge: Judge, hil_evidence: Evidence
) -> None:
    whole = hil_config.level == Level.EXHAUSTIVE
    proof = prove(hil_subject, None if whole else SAMPLED_CELLS, hil_config.seed)
    hil_evidence.proof(proof)
    trial = proof.trial()
    trial.note = proof.text()
    hil_judge(trial)
    assert proof.proven if whole else proof.tried == SAMPLED_CELLS
