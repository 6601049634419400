"""`cgagen ports`, and what `cgagen doctor` says of them."""

import json

import pytest

from cgagen.cli import main
from cgagen.link.ports import PortInfo
from tests.flash_cases import robot


def test_ports_are_listed_with_what_is_behind_them(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from cgagen.link import condition

    with robot() as (_, urls):
        found = (
            PortInfo(urls["main"], 0x0403, 0x6001, "A1", "FT232R"),
            PortInfo("/dev/gone", 0x0403, 0x6001),
        )
        monkeypatch.setattr(condition, "all_ports", lambda: found)
        monkeypatch.setattr(condition.os.path, "exists", lambda name: "://" in name)
        monkeypatch.setattr(condition, "may_open", lambda name: True)
        assert main(["ports"]) == 0
        assert capsys.readouterr().out.splitlines() == [
            f"{urls['main']} (0403:6001, id:A1, FT232R): free",
            "/dev/gone (0403:6001): it is not there; look at the cable, and at `cgagen ports`",
        ]
        assert main(["--json", "ports", "--identify"]) == 0
        told = json.loads(capsys.readouterr().out)
        main(["doctor", "--identify"])
    diagnoses = capsys.readouterr().out.splitlines()[-2:]
    assert diagnoses == [
        f"ok      port {urls['main']}: BS2p24, interpreter version 1.0",
        "-       port /dev/gone: it is not there; look at the cable, and at `cgagen ports`",
    ]
    assert told[0]["found"]["module"] == "BS2p24"
    assert told[1]["found"] is None


def test_doctor_looks_at_ports_without_opening_them(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from cgagen.link import condition, port

    def opened(*_: object) -> None:
        raise AssertionError("doctor opens nothing")

    monkeypatch.setattr(port, "open_port", opened)
    monkeypatch.setattr(condition, "all_ports", lambda: (PortInfo("/dev/null"),))
    monkeypatch.setattr(condition, "may_open", lambda name: False)
    assert main(["doctor"]) == 0
    assert "-       port /dev/null: you may not" in capsys.readouterr().out
