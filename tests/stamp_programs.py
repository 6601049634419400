"""The programs in `tests/programs/`, with what they are expected to send."""

import re
from dataclasses import dataclass
from pathlib import Path

FOLDER = Path(__file__).parent / "programs"

LIMIT_NS = 10_000_000_000


@dataclass(frozen=True)
class StampProgram:
    """One program.

    Attributes:
        path: its source.
        expected: every byte that it sends.
        typed: what a user types.
        bench: its bench file; None where one bare chip will do.
        limit_ns: how long it runs.
        ends: it reaches END or STOP in that time.
    """

    path: Path
    expected: bytes
    typed: bytes
    bench: Path | None
    limit_ns: int
    ends: bool

    @property
    def name(self) -> str:
        return self.path.stem


def unescaped(text: str) -> bytes:
    r"""Return the bytes that a .out file stands for.

    >>> unescaped("a\n\\x00b")
    b'a\r\x00b'
    """
    sent = text.encode("ascii").replace(b"\n", b"\r")
    return re.sub(rb"\\x([0-9A-F]{2})", lambda found: bytes.fromhex(found[1].decode()), sent)


def sources() -> list[Path]:
    """All sources, those of second Stamps and further slots too."""
    return sorted(path for path in FOLDER.iterdir() if path.suffix in {".bs2", ".bsp"})


def programs() -> list[StampProgram]:
    """All programs with an expected output, by name."""
    return [_program(path) for path in sources() if path.with_suffix(".out").exists()]


def _program(path: Path) -> StampProgram:
    typed, bench = path.with_suffix(".in"), path.with_suffix(".toml")
    runs = re.search(r"^' Runs: (\d+)ms$", path.read_text(), re.MULTILINE)
    return StampProgram(
        path=path,
        expected=unescaped(path.with_suffix(".out").read_text()),
        typed=typed.read_bytes() if typed.exists() else b"",
        bench=bench if bench.exists() else None,
        limit_ns=int(runs[1]) * 1_000_000 if runs else LIMIT_NS,
        ends=runs is None,
    )
