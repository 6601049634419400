"""SIN is tied to SOUT: whatever a host sends comes back to it. Ref: S10."""

ECHO_S = 0.5
"""An echo that has not come after so long does not come; a character takes 1 ms. Choice."""


class EchoFilter:
    r"""Takes the echo of what was sent out of what is received.

    Attributes:
        missing: bytes whose echo never came.

    >>> echo = EchoFilter()
    >>> echo.sent(b"ab", 0.0)
    >>> echo.received(b"a", 0.0), echo.received(b"xb!", 0.1)
    (b'', b'x!')
    """

    def __init__(self) -> None:
        self.missing = 0
        self._awaited: list[tuple[int, float]] = []

    def sent(self, data: bytes, now_s: float) -> None:
        """Note what was sent."""
        self._awaited += [(byte, now_s) for byte in data]

    def received(self, data: bytes, now_s: float) -> bytes:
        """Return what came from the chip itself.

        What the chip says while it is spoken to stands between the echoes; where it happens to say
        just the character that is awaited, the echo behind it is shown in its place: same bytes.
        """
        self._forget(now_s)
        kept = bytearray()
        for byte in data:
            if self._awaited and byte == self._awaited[0][0]:
                self._awaited.pop(0)
            else:
                kept.append(byte)
        return bytes(kept)

    def _forget(self, now_s: float) -> None:
        while self._awaited and now_s - self._awaited[0][1] > ECHO_S:
            self._awaited.pop(0)
            self.missing += 1
