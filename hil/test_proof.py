"""The whole sensor space of the main controller on trial, cell by cell.

A sample of the cells always, all of them with `--hil-level exhaustive`.
"""

from collections.abc import Callable
from typing import Any

import pytest

from cgagen.pytest_plugin.session import SESSION
from hil.equivalence import Trial
from hil.evidence import Evidence
from hil.proof import prove
from hil.stimuli import Level
from hil.subject import Subject
from hil.verify import SAMPLED_CELLS

Judge = Callable[[Trial], Trial]


WHOLE = pytest.param(None, id="whole", marks=pytest.mark.hil_req("SPACE"))
"""Only all of the cells stand for the whole space."""


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Take as many cells as the level says."""
    whole = metafunc.config.stash[SESSION].asked.level == Level.EXHAUSTIVE
    metafunc.parametrize("cells", [WHOLE if whole else pytest.param(SAMPLED_CELLS, id="sample")])


@pytest.mark.hil_req("DECISIONS")
def test_the_image_decides_as_the_simulator(
    hil_subject: Subject,
    hil_config: Any,
    hil_judge: Judge,
    hil_evidence: Evidence,
    cells: int | None,
) -> None:
    proof = prove(hil_subject, cells, hil_config.seed)
    hil_evidence.proof(proof)
    hil_judge(proof.trial())
    assert proof.tried == (proof.cells if cells is None else min(cells, proof.cells))
