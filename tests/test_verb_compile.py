"""`cgagen compile` as a user calls it."""

import json
from pathlib import Path

import pytest

from cgagen.cli import main
from tests.compile_cases import HEAD, LED, LED_TAIL


@pytest.fixture
def led(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "led.bs2"
    path.write_bytes(LED.encode())
    return path


def test_compile_writes_image_and_map(led: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["compile", "led.bs2", "-o", "led.bin", "--map", "led.map"]
    assert main(words) == main(words) == 0  # our own files may be replaced
    out = capsys.readouterr()
    assert "program                      5 bytes" in out.out
    image = (led.parent / "led.bin").read_bytes()
    assert (len(image), image[-4:]) == (2048, LED_TAIL)
    assert (led.parent / "led.map").read_text() == "line,column,bit\n2,1,14\n"


def test_compile_tells_everything_as_json(led: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--json", "compile", "led.bs2"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert bytes.fromhex(data["eeprom"])[-4:] == LED_TAIL
    assert data["packets"] == ["ff" + "00" * 11 + "00140e07c018"]
    assert data["source_map"] == [{"offset": 15, "line": 2, "column": 1, "bit": 14}]
    assert (data["model"], data["memory"]["free_bytes"]) == ("BS2", 2043)
    assert set(bytes.fromhex(data["flags"])) == {0, 0x80, 0x83}


@pytest.mark.parametrize("option", ["-o", "--map"])
def test_compile_overwrites_nothing_of_the_users(
    led: Path, capsys: pytest.CaptureFixture[str], option: str
) -> None:
    precious = led.with_name("thesis.txt")
    precious.write_text("years of work")
    assert main(["compile", "led.bs2", option, "thesis.txt"]) == 3
    assert "--force" in capsys.readouterr().err
    assert precious.read_text() == "years of work"
    assert main(["compile", "led.bs2", option, "led.bs2", "--force"]) == 2
    assert led.read_bytes() == LED.encode()
    assert main(["compile", "led.bs2", option, "thesis.txt", "--force"]) == 0
    assert precious.read_bytes() != b"years of work"


def test_a_refused_source_writes_nothing(led: Path, capsys: pytest.CaptureFixture[str]) -> None:
    led.write_text(HEAD + "HIGH foo\n")
    assert main(["compile", "led.bs2", "-o", "led.bin"]) == 6
    assert capsys.readouterr().err == "cgagen: led.bs2:3:6: 110-Undefined symbol (foo)\n"
    assert [path.name for path in led.parent.iterdir()] == ["led.bs2"]


@pytest.mark.parametrize(
    ("content", "code", "words"),
    [
        (b"\xef\xbb\xbf" + LED.encode(), 0, ""),  # a mark that some editors put first
        (LED.encode() + b"' 5 \xb5s\n", 0, ""),  # Windows-1252
        (LED.encode() + "' 5 \u00b5s\n".encode(), 0, ""),
        (LED.encode("utf-16"), 6, "UTF-16"),
        (bytes(range(256)), 6, "silently"),
        (b"", 6, "156"),
    ],
)
def test_any_file_is_compiled_or_refused(
    led: Path, capsys: pytest.CaptureFixture[str], content: bytes, code: int, words: str
) -> None:
    led.write_bytes(content)
    assert main(["compile", "led.bs2"]) == code
    assert words in capsys.readouterr().err


def test_a_source_that_is_not_there(led: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["compile", "lad.bs2"]) == 6
    assert "lad.bs2: cannot be read (No such file" in capsys.readouterr().err


def test_further_files_are_named_in_a_note(led: Path, capsys: pytest.CaptureFixture[str]) -> None:
    led.write_text("' {$STAMP BS2e, more.bse}\nHIGH 1\n")
    assert main(["compile", "led.bs2"]) == 0
    assert "more.bse" in capsys.readouterr().err
