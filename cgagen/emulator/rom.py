"""How each model tells who it is: what its loader waits for, and what it answers.

Written from two free programmers, bstamp and stampbc, that were made after Parallax's own
description, and from Parallax's JavaScript programmer, bs2-serial 0.15.0. Nothing of it has been
tried on a chip.
"""

from typing import NamedTuple

from cgagen.errors import BenchError


class Identity(NamedTuple):
    """One model's part of the conversation.

    Attributes:
        challenge: what the loader waits for, byte by byte. All but the last are answered with
            256 - byte, the last with the version.
        versions: what it may answer to the last, oldest first.
    """

    challenge: bytes
    versions: bytes


IDENTITIES: dict[tuple[str, int], Identity] = {
    # model, legs
    ("BS2", 24): Identity(b"BS2\0", bytes.fromhex("10")),
    ("BS2e", 24): Identity(b"e", bytes.fromhex("65 66 67")),
    ("BS2sx", 24): Identity(b"X", bytes.fromhex("58 59 5A 5B")),
    ("BS2p", 24): Identity(b"P", bytes(range(0x70, 0x78))),
    ("BS2p", 40): Identity(b"P", bytes(range(0x50, 0x58))),
    ("BS2pe", 24): Identity(b"I", bytes(range(0x69, 0x6E))),
    ("BS2pe", 40): Identity(b"I", bytes(range(0x49, 0x4E))),
}
"""A BS2 says its version in two decimal digits: 10h is 1.0."""


def identity(model: str, legs: int = 24) -> Identity:
    """Return how a model tells who it is.

    Args:
        model: as Parallax writes it.
        legs: of the module: 24, or 40 for a BS2p40 or BS2pe40.

    Raises:
        BenchError: the model is not made with so many legs.

    >>> identity("BS2p", 40).versions[:1]
    b'P'
    """
    try:
        return IDENTITIES[model, legs]
    except KeyError:
        raise BenchError(f"a {model} with {legs} legs is not made; leave the legs out") from None
