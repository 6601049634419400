"""`cgagen info IMAGE.bin`: a listing that compiles again, with what is known of the image."""

import json
import shutil
from pathlib import Path

import pytest

from cgagen.cli import main
from cgagen.tokenizer import Tokenizer
from cgagen.tokenizer.files import write_image
from tests.subjects import FIRMWARE

SOURCE = "' {$STAMP BS2e}\n' {$PBASIC 2.5}\nagain:  HIGH 3  ' on\nGOTO again : DATA 7, (2)\n"


@pytest.fixture
def image_file(tmp_path: Path, tokenizer: Tokenizer) -> Path:
    """An image beside its source."""
    path = tmp_path / "led.bin"
    write_image(path, tokenizer.compile(SOURCE).image)
    path.with_suffix(".bse").write_text(SOURCE)
    return path


def info(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str, str]:
    code = main([*words[:-1], "info", words[-1]] if words[0] == "--json" else ["info", *words])
    out, err = capsys.readouterr()
    return code, out, err


def test_with_its_source(image_file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = info(capsys, str(image_file))
    assert (code, err) == (0, "")
    lines = out.splitlines()
    assert lines[2].startswith("' led.bin: an image for a BS2e, digest ")
    assert lines[3] == "' program 8 bytes, DATA 3 bytes, free 2037 bytes"
    assert lines[4] == "' 3 instructions, 0 GOSUBs"
    assert lines[7:] == [
        "        ' 3: again:  HIGH 3  ' on",
        "L14:    HIGH 3",
        "        ' 4: GOTO again : DATA 7, (2)",
        "        GOTO L14",
        "        DATA @0, 7",
        "        DATA @1, (2)",
    ]


def test_what_is_printed_compiles_to_the_image(
    image_file: Path, capsys: pytest.CaptureFixture[str], tokenizer: Tokenizer
) -> None:
    for words in ((str(image_file),), ("--model", "bs2e", str(image_file))):
        _, out, _ = info(capsys, *words)
        assert tokenizer.compile(out).image.eeprom == image_file.read_bytes()


@pytest.mark.parametrize("robot", ["predator", "prey"])
@pytest.mark.parametrize("name", ["main.bin", "locomotion.bin"])
def test_in_a_build(
    robot: str, name: str, capsys: pytest.CaptureFixture[str], tokenizer: Tokenizer
) -> None:
    file = FIRMWARE / robot / name
    code, out, err = info(capsys, str(file))
    assert (code, err) == (0, "")
    assert "comments with a number are the lines of " in out
    assert tokenizer.compile(out).image.eeprom == file.read_bytes()


def test_a_changed_image_of_a_build_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "build"
    shutil.copytree(FIRMWARE / "prey", folder)
    file = folder / "main.bin"
    file.write_bytes(b"\1" + file.read_bytes()[1:])
    code, out, err = info(capsys, str(file))
    assert (code, out) == (3, "")
    assert "its digest is not the one in build.json" in err
    code, out, err = info(capsys, "--model", "BS2p", str(file))
    assert code == 0
    assert "makes another image than main.bin" in err
    assert "DATA @0, 1" in out


def test_without_its_source(image_file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    image_file.with_suffix(".bse").unlink()
    code, _, err = info(capsys, str(image_file))
    assert code == 2
    assert "add --model with one of BS2, BS2e, BS2sx, BS2p, BS2pe" in err
    code, out, err = info(capsys, "--model", "BS2e", str(image_file))
    assert (code, err) == (0, "")
    assert "DATA 1 bytes that are not 0" in out
    assert out.splitlines()[6:] == ["L14:    HIGH 3", "        GOTO L14", "        DATA @0, 7"]


def test_with_a_source_that_is_refused(
    image_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    image_file.with_suffix(".bse").write_text("nonsense\n")
    code, _, err = info(capsys, "--model", "BS2e", str(image_file))
    assert code == 0
    assert err.startswith("note: without the lines of led.bse: led.bse")


def test_a_directive_in_a_line_stays_a_comment(
    image_file: Path, capsys: pytest.CaptureFixture[str], tokenizer: Tokenizer
) -> None:
    image_file.with_suffix(".bse").write_text(SOURCE.replace("' on", "' {$PORT COM1}"))
    _, out, _ = info(capsys, "--model", "BS2e", str(image_file))
    assert "' 3: again:  HIGH 3  ' { $PORT COM1}" in out
    assert tokenizer.compile(out).port == ""


def test_as_json(image_file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    _, out, _ = info(capsys, "--json", str(image_file))
    data = json.loads(out)
    assert (data["kind"], data["model"]) == ("image", "BS2e")
    assert (data["program_bytes"], data["data_bytes"], data["start_bit"]) == (8, 3, 14)
    assert data["gosub_slots"] == []
    assert {"bit": 14, "text": "L14:    HIGH 3"} in data["listing"]


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "has 2048 bytes, this one has 0"),
        (b"\0" * 2049, "has 2048 bytes, this one has 2049"),
        (b"\0" * 2048, "no program starts at stream bit 0"),
        (b"\xff" * 2048, "no program starts at stream bit 16383"),
    ],
)
def test_what_is_no_image(
    tmp_path: Path, content: bytes, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "x.bin"
    file.write_bytes(content)
    code, out, err = info(capsys, "--model", "BS2", str(file))
    assert (code, out) == (3, "")
    assert words in err
    assert "no such file" in info(capsys, "--model", "BS2", str(tmp_path / "none.bin"))[2]
    assert "there is no model 'BS3'" in info(capsys, "--model", "BS3", str(file))[2]
