"""`cgagen monitor --json`: an object for each line of a chip's; and what is said at the start."""

import json

import pytest

from cgagen.cli import main
from cgagen.link import ports as ports_module
from cgagen.link.ports import PortInfo
from cgagen.verbs.console import Console
from cgagen.verbs.monitor import LONGEST_LINE, JsonLines
from tests.subjects import FIRMWARE

EMULATED = ["monitor", "--port", f"emu:{FIRMWARE / 'prey'}", "--input", ""]


def objects(text: str) -> list[dict[str, object]]:
    return [json.loads(line) for line in text.splitlines()]


def test_every_line_of_a_chip_is_an_object(capsys: pytest.CaptureFixture[str]) -> None:
    """All bytes come back: those that are no characters, and those that never came to a CR."""
    times = iter([0.5, 1.25, 2.0, 3.0])
    lines = JsonLines(Console(as_json=True), lambda: next(times))
    for data in (b"on", b"e\r\r", b"\x00\xff\x1b[2J\r", b"half"):
        lines.write(data)
    lines.close()
    lines.close()
    assert objects(capsys.readouterr().out) == [
        {"time_s": 0.5, "text": "one", "ended": True},
        {"time_s": 1.25, "text": "", "ended": True},
        {"time_s": 2.0, "text": "\x00\xff\x1b[2J", "ended": True},
        {"time_s": 3.0, "text": "half", "ended": False},
    ]


def test_a_line_without_end_is_told_in_parts(capsys: pytest.CaptureFixture[str]) -> None:
    lines = JsonLines(Console(as_json=True), lambda: 0.0)
    lines.write(b"x" * (2 * LONGEST_LINE + 1) + b"\r")
    said = [(len(str(one["text"])), one["ended"]) for one in objects(capsys.readouterr().out)]
    assert said == [(LONGEST_LINE, False), (LONGEST_LINE, False), (1, True)]


def test_a_robot_at_work_as_json(capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["--json", *EMULATED, "--for", "2s"]) == 0
    out, err = capfd.readouterr()
    found = objects(out)
    assert any(str(one["text"]).startswith("#1 M servobot-prey ") for one in found)
    assert all(isinstance(one["time_s"], float) for one in found)
    assert "listening at 9600 baud; Ctrl-C ends it, or --for after 2 s" in err
    assert main([*EMULATED, "--for", "1s", "-q", "--json"]) == 0
    assert capfd.readouterr().err == ""


def test_raw_bytes_and_json_exclude_each_other(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--json", *EMULATED, "--raw"]) == 2
    assert "--raw is bytes" in capsys.readouterr().err


@pytest.mark.parametrize("verb", [["monitor"], ["robot", "sensors"], ["robot", "centre"]])
def test_a_port_of_the_board_is_never_chosen(
    verb: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(ports_module, "all_ports", lambda: (PortInfo("/dev/no-port"),))
    assert main(verb) == 7
    assert "auto: no USB adapter is there; the ports are /dev/no-port" in capsys.readouterr().err
