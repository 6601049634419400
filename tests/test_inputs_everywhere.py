"""Nothing of the product opens a file by itself, or parses TOML and JSON by itself."""

import ast
from pathlib import Path

ROOT = Path(__file__).parent.parent

READERS = {"read_text", "read_bytes", "loads", "load", "decompress", "fdopen"}
"""Names that read when they are called on `Path`, `json`, `tomllib`, `numpy`, `gzip` or `os`."""

MODULES = {"json", "tomllib", "np", "numpy", "gzip", "zlib", "os", "tarfile", "zipfile", "io"}

ALLOWED = {
    "cgagen/inputs.py": "the one reader",
    "cgagen/notations.py": "the one parser",
    "cgagen/robot/reader.py read_text": "robots that ship with cgagen",
    "cgagen/firmware/confined.py loads": "what our own process answers",
    "cgagen/link/why.py read_text": "/proc",
    "cgagen/toolchain/fetch.py read_bytes": "what ships, and what npm has just unpacked",
    "cgagen/toolchain/node.py open": "the first line of a program on PATH",
    "cgagen/verbs/build.py loads": "the record that was just made",
    "cgagen/tokenizer/worker.py open": "the null device",
    "cgagen/tokenizer/worker.py loads": "what our own process answers",
    "cgagen/pytest_plugin/session.py loads": "what a worker of pytest-xdist hands over",
    "hil/report.py loads": "what was just dumped",
    "hil/colony_bench.py loads": "the bench that was just written",
    "sim/jit.py read_text": "our own sources",
}


def _calls(path: Path) -> set[str]:
    """Return the names of calls in a file that may read one."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if not isinstance(node, ast.Call):
            continue
        function = node.func
        words = [word.value for word in node.args if isinstance(word, ast.Constant)]
        if isinstance(function, ast.Name) and function.id == "open":
            found.add("open")
        if not isinstance(function, ast.Attribute):
            continue
        owner = function.value.id if isinstance(function.value, ast.Name) else ""
        if function.attr in {"read_text", "read_bytes"} and owner != "inputs":
            found.add(function.attr)
        elif function.attr in READERS and owner in MODULES - {"os", "io"}:
            found.add(function.attr)
        elif function.attr == "open" and words and set("rbt") >= set(str(words[0])):
            found.add("open")
    return found


def test_every_file_is_read_by_the_one_reader() -> None:
    strangers = []
    for folder in ("cgagen", "sim", "hil"):
        for path in sorted((ROOT / folder).rglob("*.py")):
            name = str(path.relative_to(ROOT))
            if name in ALLOWED or path.name.startswith("test_"):
                continue
            strangers += [one for call in _calls(path) if (one := f"{name} {call}") not in ALLOWED]
    assert strangers == []


def test_what_is_allowed_is_there() -> None:
    for one in ALLOWED:
        name, _, call = one.partition(" ")
        assert not call or call in _calls(ROOT / name), one
