"""The rules of the house that no linter knows."""

import ast
import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from cgagen.cli import VERBS, cgagen, main
from cgagen.errors import CgagenError

ROOT = Path(__file__).parent.parent
CODE = sorted(
    path
    for room in ("cgagen", "sim", "hil")
    for path in (ROOT / room).rglob("*.py")
    if not path.name.startswith("test_")
)

LONG_FILES: dict[str, str] = {
    "cgagen/emulator/timing.py": "every duration and unit of the chips, each with its source",
    "cgagen/robot/values.py": "the whole robot as values, a page per part",
    "sim/numbers.py": "the whole world as values, and how each is made",
    "hil/dataflow.py": "one abstract machine; its parts share one state",
}
"""Files over 300 lines, each with its reason."""

TESTS = sorted([*(ROOT / "tests").glob("*.py"), *(ROOT / "hil").glob("test_*.py")])


def longer_than(limit_lines: int, paths: list[Path]) -> set[str]:
    return {
        str(path.relative_to(ROOT))
        for path in paths
        if len(path.read_text("utf-8").splitlines()) > limit_lines
    }


def test_files_are_small() -> None:
    long = longer_than(300, CODE) - set(LONG_FILES)
    assert not long, f"split, or give a reason: {sorted(long)}"


def test_a_reason_is_given_for_long_files_only() -> None:
    assert set(LONG_FILES) <= longer_than(300, CODE)


def test_files_of_tests_have_one_topic() -> None:
    long = longer_than(400, TESTS)
    assert not long, f"split by topic: {sorted(long)}"


def test_help_is_quick_to_import() -> None:
    """Start-up is measured by `cgagen benchmark`; what would ruin it is checked here."""
    done = subprocess.run(
        [sys.executable, "-X", "importtime", "-m", "cgagen", "--help"],
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
        stdin=subprocess.DEVNULL,
    )
    imported = {line.rsplit("|", 1)[-1].strip() for line in done.stderr.splitlines()}
    heavy = {"numpy", "numba", "jinja2", "rich", "serial", "can", "sim", "cgagen.robot"}
    assert not heavy & imported


@pytest.mark.parametrize("verb", VERBS)
def test_every_verb_has_help(verb: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([verb, "--help"]) == 0
    out = capsys.readouterr().out
    assert out.startswith("Usage: cgagen " + verb)
    assert r"\b" not in out


def test_the_table_lists_the_verbs(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--help"]) == 0
    out = capsys.readouterr().out
    assert all(f"\n  {verb} " in out for verb in VERBS)


def test_unknown_words_are_usage_errors(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["fly"]) == 2
    assert main(["evolve", "--wings", "2"]) == 2
    assert "No such option" in capsys.readouterr().err


def test_ctrl_c_is_a_sentence(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def pressed(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(cgagen, "main", pressed)
    assert main(["info", "x"]) == 130
    assert capsys.readouterr().err.count("\n") == 1


def test_a_bug_is_a_sentence_too(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def broken(*_: object, **__: object) -> None:
        raise ZeroDivisionError("nobody thought of it")

    monkeypatch.setattr(cgagen, "main", broken)
    assert main(["info", "x"]) == 1
    err = capsys.readouterr().err
    assert "bug of ours" in err
    assert "Traceback" not in err


@pytest.mark.parametrize("verb", ["ports", "evolve"])
def test_windows_is_told_where_it_runs(verb: str) -> None:
    lacks = "import sys; sys.modules.update(fcntl=None, termios=None, pty=None, grp=None)"
    code = f"{lacks}; from cgagen.cli import main; sys.exit(main(['{verb}']))"
    words = [sys.executable, "-c", code]
    done = subprocess.run(
        words, check=False, capture_output=True, text=True, timeout=60, stdin=subprocess.DEVNULL
    )
    assert done.returncode == 4
    assert "needs Linux or macOS; on Windows" in done.stderr


def test_every_error_has_its_own_sentence_and_code() -> None:
    leaves = CgagenError.__subclasses__()
    assert {leaf.exit_code for leaf in leaves} <= set(range(3, 12))
    assert all(leaf.__doc__ for leaf in leaves)


def test_versions_agree() -> None:
    from cgagen import __version__

    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    assert project["version"] == __version__


def test_every_reference_has_a_source() -> None:
    known = set(re.findall(r"^\| (S\d+) \|", (ROOT / "SOURCES.md").read_text("utf-8"), re.M))
    files = [*CODE, *(ROOT / "cgagen" / "robots").glob("*.toml"), *(ROOT / "templates").iterdir()]
    used = {
        (key, path.name)
        for path in files
        for key in re.findall(r"\b[Rr]ef:? ?(S\d+)", path.read_text("utf-8"))
    }
    assert {key for key, _ in used} <= known
    assert len(used) > 20


def test_every_decision_that_is_named_exists() -> None:
    known = set(re.findall(r"^\*\*(\d+)\.", (ROOT / "DECISIONS.md").read_text("utf-8"), re.M))
    named = {
        number
        for path in [*CODE, *(ROOT / "cgagen" / "robots").glob("*.toml")]
        for number in re.findall(r"DECISIONS\.md (\d+)", path.read_text("utf-8"))
    }
    assert named <= known
    assert named


def _console_blocks(text: str) -> list[list[str]]:
    """Return the commands of every ```console block, without their output."""
    blocks = re.findall(r"```console\n(.*?)```", text, re.S)
    return [[line[2:] for line in block.splitlines() if line.startswith("$ ")] for block in blocks]


def test_readme_commands_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every `$ cgagen ...` of the README runs, in order, in one empty folder.

    Evolution is shortened, because the README shows the paper's full trial.
    """
    monkeypatch.chdir(tmp_path)
    blocks = _console_blocks((ROOT / "README.md").read_text("utf-8"))
    ours = [command for block in blocks for command in block if command.startswith("cgagen ")]
    assert len(ours) >= 4
    for command in ours:
        words = shlex.split(command)[1:]
        if words[0] == "evolve":
            words += ["--generations", "2", "--population", "16"]
        assert main(words) == 0, command


def test_readme_names_make_targets_that_exist() -> None:
    targets = set(re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text("utf-8"), re.M))
    named = set(re.findall(r"(?:`|^)make ([a-z]+)", (ROOT / "README.md").read_text("utf-8"), re.M))
    assert {"demo", "test"} <= named <= targets


CALLS = {"run", "Popen", "call", "check_call", "check_output"}


def calls_without_stdin(source: str) -> list[int]:
    """Return the lines at which a process is begun that may read what is not meant for it."""
    found = [
        node
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.Call)
        and isinstance(node.func, ast.Attribute)
        and isinstance(node.func.value, ast.Name)
        and node.func.value.id == "subprocess"
        and node.func.attr in CALLS
    ]
    said = [{keyword.arg for keyword in node.keywords} for node in found]
    return [
        node.lineno
        for node, words in zip(found, said, strict=True)
        if not words & {"stdin", "input"}
    ]


def test_no_process_inherits_stdin() -> None:
    """What stands there is a shell's list, or what somebody types at the tests."""
    assert calls_without_stdin("subprocess.run(['x'])\nsubprocess.Popen(['x'], stdin=None)") == [1]
    paths = [
        path for room in ("cgagen", "sim", "hil", "tests") for path in (ROOT / room).rglob("*.py")
    ]
    lines = {
        f"{path.relative_to(ROOT)}:{line}"
        for path in paths
        for line in calls_without_stdin(path.read_text("utf-8"))
    }
    assert not lines
    assert len(paths) > 400


WRITES = re.compile(
    r"\bos\.(replace|rename|truncate)\(|\bmk[sd]?temp\(|Named?TemporaryFile|TemporaryDirectory"
    r"|(?<!files)\.write_(text|bytes)\(|\.rename\(|open\([^)\n]*\"[wax][b+]*\"|shutil\.(copy|move)"
)

WRITERS = {
    "cgagen/files.py": "the one way",
    "cgagen/build/folder.py": "whole folders, from temporary ones",
    "cgagen/build/make.py": "a refused program, in a new folder of the system's",
    "cgagen/verbs/ending.py": "a bug's report, a new file",
    "cgagen/tokenizer/worker.py": "what a process of ours says goes to a file without a name",
    "cgagen/pytest_plugin/artifacts.py": "by cgagen.files, imported late",
    "hil/emulated.py": "in a temporary folder",
    "hil/colony_bench.py": "in a temporary folder",
}
"""Where files are written, each with its reason; all else goes through `cgagen.files`."""


def test_outputs_are_written_in_one_way() -> None:
    """Whoever renames onto a user's name without a look takes devices away."""
    found = {str(path.relative_to(ROOT)) for path in CODE if WRITES.search(path.read_text("utf-8"))}
    assert found == set(WRITERS)
