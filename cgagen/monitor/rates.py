"""The rate of a sender that is slower than who listens, from the bytes that come of it."""

from collections import Counter
from itertools import groupby

from cgagen.stamp.serial_mode import usual

ENOUGH_BYTES = 16
"""Fewer have too few pieces that are whole. Choice."""

SHARE = 0.05
"""So many of the pieces at least are as short as a bit; a spoiled byte has others. Choice."""


def slower_rate(data: bytes, baud: int) -> int | None:
    """Return the rate at which these bytes would have been sent; None where none can be told.

    A listener that is too fast takes each bit for several, so the shortest piece of one level is
    one bit of the sender's. Of a sender that is faster, too much is lost.

    Args:
        data: that came.
        baud: of the listener.

    >>> slower_rate(bytes.fromhex("00807880f8788000f878f878787880787878f800"), 9600)  # "Hi there"
    2400
    >>> slower_rate(b"Hi there, Hi there, Hi there", 9600) is None
    True
    """
    if len(data) < ENOUGH_BYTES:
        return None
    pieces: Counter[int] = Counter()
    for byte in data:
        # The start bit begins with an edge; how long the last piece is, nobody knows.
        bits = [0, *(byte >> place & 1 for place in range(8))]
        pieces.update([len([*same]) for _, same in groupby(bits)][:-1])
    few = SHARE * pieces.total()
    shortest = min((length for length, times in pieces.items() if times > few), default=1)
    return None if shortest < 2 else usual(baud / shortest)
