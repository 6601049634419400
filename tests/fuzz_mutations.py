"""Small and large damage to files: one mutator for every kind, reproducible from a seed."""

import random
import re
from collections.abc import Callable, Sequence

Change = Callable[[bytes, random.Random, Sequence[bytes]], bytes]

_NUMBER = re.compile(rb"-?\d+(?:\.\d+)?(?:[eE][+-]?\d+)?")

ODD_NUMBERS = (
    b"0", b"-1", b"1e999", b"-1e999", b"nan", b"inf", b"NaN", b"Infinity", b"65535", b"65536",
    b"4294967296", b"18446744073709551616", b"1" * 40, b"1" * 5_000, b"0.1", b"1e-320", b"-0",
    b"00", b"0x10", b"1_000", b"\xd9\xa3", b"true", b'""', b"[]", b"{}", b"null",
)  # fmt: skip

PIECES = (
    b"\0", b"\x1b[31m", b"\x9b2J", b"\r", b"\r\n", b"\n", b"\t", b"\xff", b"\xc3\xa9", b'"', b"'",
    b"[", b"]", b"{", b"}", b",", b"=", b"#", b"/", b"../", b"\\", b"\\u0000", b'"\\ud800"',
    b"\xe2\x80\xae", b"\xef\xbb\xbf", b"[" * 5_000, b"{" * 5_000, b'{"a":' * 5_000, b"a." * 5_000,
    b"[[a]]\n" * 50, b"9" * 5_000, b"\n" * 5_000, b"x" * 70_000, b'"a" . ' * 3_000, b"(" * 2_000,
)  # fmt: skip


def _flip(data: bytes, rng: random.Random, _others: Sequence[bytes]) -> bytes:
    changed = bytearray(data)
    for _ in range(rng.choice((1, 1, 1, 2, 8, 64))):
        if changed:
            changed[rng.randrange(len(changed))] ^= 1 << rng.randrange(8)
    return bytes(changed)


def _cut(data: bytes, rng: random.Random, _others: Sequence[bytes]) -> bytes:
    return data[: rng.randrange(len(data) + 1)]


def _behead(data: bytes, rng: random.Random, _others: Sequence[bytes]) -> bytes:
    return data[rng.randrange(len(data) + 1) :]


def _without(data: bytes, rng: random.Random, _others: Sequence[bytes]) -> bytes:
    one, other = sorted(rng.randrange(len(data) + 1) for _ in range(2))
    return data[:one] + data[min(other, one + 400) :]


def _twice(data: bytes, rng: random.Random, _others: Sequence[bytes]) -> bytes:
    one, other = sorted(rng.randrange(len(data) + 1) for _ in range(2))
    return data[:other] + data[one:other] * rng.choice((1, 1, 3)) + data[other:]


def _insert(data: bytes, rng: random.Random, _others: Sequence[bytes]) -> bytes:
    at = rng.randrange(len(data) + 1)
    return data[:at] + rng.choice(PIECES) + data[at:]


def _number(data: bytes, rng: random.Random, _others: Sequence[bytes]) -> bytes:
    found = list(_NUMBER.finditer(data[:200_000]))
    if not found:
        return _insert(data, rng, _others)
    one = rng.choice(found)
    return data[: one.start()] + rng.choice(ODD_NUMBERS) + data[one.end() :]


def _lines(data: bytes, rng: random.Random, _others: Sequence[bytes]) -> bytes:
    lines = data.split(b"\n")
    one, other = rng.randrange(len(lines)), rng.randrange(len(lines))
    how = rng.randrange(4)
    if how == 0:
        lines[one], lines[other] = lines[other], lines[one]
    elif how == 1:
        del lines[one]
    elif how == 2:
        lines.insert(other, lines[one])
    else:
        lines[one] = lines[other]
    return b"\n".join(lines)


def _words(data: bytes, rng: random.Random, _others: Sequence[bytes]) -> bytes:
    """Put one word of the file in the place of another: keys, values, names."""
    words = sorted(set(re.findall(rb"[A-Za-z_][\w.-]*", data[:100_000])))
    if len(words) < 2:
        return _flip(data, rng, _others)
    one, other = rng.sample(words, 2)
    return data.replace(one, other, rng.choice((1, -1)))


def _other_kind(_data: bytes, rng: random.Random, others: Sequence[bytes]) -> bytes:
    return rng.choice(others) if others else b""


def _encoded(data: bytes, rng: random.Random, _others: Sequence[bytes]) -> bytes:
    text = data.decode("latin-1")
    how = rng.randrange(4)
    if how == 0:
        return text.encode("utf-16")
    if how == 1:
        return b"\xef\xbb\xbf" + data
    return data.replace(b"\n", b"\r\n" if how == 2 else b"\r")


CHANGES: tuple[Change, ...] = (
    _flip, _cut, _behead, _without, _twice, _insert, _number, _number, _lines, _words, _other_kind,
    _encoded,
)  # fmt: skip


def mutated(data: bytes, rng: random.Random, others: Sequence[bytes]) -> bytes:
    """Return a file with one to three changes.

    Args:
        data: a file that is right.
        rng: decides everything.
        others: files of other kinds.
    """
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        data = rng.choice(CHANGES)(data, rng, others)
    return data
