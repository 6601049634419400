"""Requirements: what the ids of the marker `hil_req` stand for, and which tests stand for them."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from cgagen.errors import RunError
from cgagen.inputs import REQUIREMENTS, read_text
from cgagen.notations import parse_toml
from hil.equivalence import Verdict

PASSED, FAILED = "passed", "failed"
OURS = Path(__file__).parent / "requirements.toml"
"""Those of cgagen's own firmware."""


def read_requirements(path: Path | None) -> dict[str, str]:
    """Return what each id stands for; nothing for no file.

    Raises:
        RunError: the file is not a table of ids and sentences.
    """
    if path is None:
        return {}
    try:
        texts = parse_toml(read_text(path, REQUIREMENTS))
    except ValueError as error:
        raise RunError(f"{path}: cannot be read ({error}); name a TOML file") from error
    if not all(isinstance(text, str) for text in texts.values()):
        raise RunError(f'{path}: every line is an id and a sentence, such as ID = "it stands"')
    return texts


def matrix(
    texts: Mapping[str, str], tests: Mapping[str, Sequence[str]], outcomes: Mapping[str, str]
) -> list[dict[str, Any]]:
    """Return a row per requirement, those of the file first and in its order.

    Args:
        texts: sentences by id.
        tests: names of tests by id.
        outcomes: of tests by name: passed, failed, skipped, BLOCKED or UNPROVEN.
    """
    ids = [*texts, *sorted(set(tests) - set(texts))]
    return [
        {
            "id": one,
            "text": texts.get(one, ""),
            "verdict": str(_verdict([outcomes[test] for test in tests.get(one, ())])),
            "tests": [
                {"test": test, "outcome": outcomes[test]} for test in sorted(tests.get(one, ()))
            ],
        }
        for one in ids
    ]


def _verdict(outcomes: Sequence[str]) -> Verdict:
    if FAILED in outcomes:
        return Verdict.FAIL
    for verdict in (Verdict.BLOCKED, Verdict.UNPROVEN):
        if verdict in outcomes:
            return verdict
    return Verdict.PASS if PASSED in outcomes else Verdict.UNPROVEN
