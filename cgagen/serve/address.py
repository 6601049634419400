"""Where a port is served, as a word of the command line."""

import re
from typing import NamedTuple, Self

from cgagen.errors import RigError

LOOPBACK = "127.0.0.1"
"""Nobody on another machine can get at what is served there."""

_WORD = re.compile(r"(?:(pty)|(tcp|rfc2217)(?::(?:([^\s:]+):)?(\d{1,5}))?)", re.ASCII)


class Address(NamedTuple):
    """One address.

    Attributes:
        kind: "rfc2217", "tcp" or "pty".
        host: whose clients may come: this machine's unless another is said.
        number: of the socket; 0 for one that is free.

    >>> Address.parse("rfc2217:0"), Address.parse("pty").kind
    (Address(kind='rfc2217', host='127.0.0.1', number=0), 'pty')
    >>> Address.parse("tcp:0.0.0.0:4000")
    Address(kind='tcp', host='0.0.0.0', number=4000)
    """

    kind: str
    host: str = LOOPBACK
    number: int = 0

    @classmethod
    def parse(cls, word: str) -> Self:
        """Return the address that a word says.

        Raises:
            RigError: it says none.
        """
        found = _WORD.fullmatch(word.strip())
        if found is None or int(found[4] or 0) > 65_535:
            raise RigError(
                f"{word}: is no place for a port; say rfc2217:0, tcp:0 or pty, with the number "
                "of a socket in place of 0 where it matters"
            )
        return cls(found[1] or found[2], found[3] or LOOPBACK, int(found[4] or 0))
