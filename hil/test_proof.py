"""The proof over the whole sensor space, for both main controllers.

A sample of the cells by default, all of them with `--hil-level exhaustive`.
"""

from pathlib import Path

import pytest

from hil.equivalence import Verdict
from hil.proof import prove
from hil.subject import read_subject

FIRMWARE = Path(__file__).parent.parent / "firmware"
SAMPLE = 6_000
"""Cells of each program in the default run. Ref: choice."""


@pytest.mark.parametrize("role", ["predator", "prey"])
def test_the_image_decides_as_the_simulator(role: str, request: pytest.FixtureRequest) -> None:
    level = request.config.getoption("--hil-level", default="smoke")
    whole = level == "exhaustive"
    proof = prove(read_subject(FIRMWARE / role), sample=None if whole else SAMPLE)
    assert proof.verdict is Verdict.PASS, proof.text()
    assert proof.proven if whole else proof.tried == SAMPLE
