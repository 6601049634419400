"""`firmware/` is what the generator makes of the reference genome and of the prey."""

from pathlib import Path

import pytest

from cgagen.cli import main
from tests.subjects import FIRMWARE


def files_of(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


@pytest.mark.parametrize(
    ("folder", "words"),
    [
        ("predator", [str(FIRMWARE / "reference.genome")]),
        ("prey", ["--robot", "servobot-prey"]),
    ],
)
def test_the_checked_in_firmware_is_current(
    folder: str, words: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["-q", "build", *words, "-o", str(tmp_path / folder)]) == 0
    capsys.readouterr()
    made, kept = files_of(tmp_path / folder), files_of(FIRMWARE / folder)
    assert set(made) == set(kept)
    differing = [name for name in kept if made[name] != kept[name]]
    assert not differing, "run `make firmware` and read the difference"
