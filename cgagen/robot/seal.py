"""The last line of a calibrated robot file: the digest of the rest, as it was written.

The comments that `cgagen calibrate` writes say how a number was measured. A number that is edited
by hand keeps its comment; the seal does not fit any more then, and `cgagen info` says so.
"""

from cgagen.files import digest

SEAL = "# calibrated; digest of all other lines: "


def sealed(text: str) -> str:
    r"""Return a text with its seal at the end, in place of an older one.

    >>> seal_fits(sealed("x = 1\n")), seal_fits(sealed("x = 1\n").replace("1", "2", 1))
    (True, False)
    """
    rest = _rest(text)
    return f"{rest}{SEAL}{digest(rest)}\n"


def seal_fits(text: str) -> bool | None:
    r"""Whether a text is as it was sealed; None where it never was.

    >>> seal_fits("x = 1\n") is None
    True
    """
    seals = [line.rstrip() for line in text.split("\n") if line.startswith(SEAL)]
    return seals == [SEAL + digest(_rest(text))] if seals else None


def _rest(text: str) -> str:
    kept = [line for line in text.split("\n") if not line.startswith(SEAL)]
    return "\n".join(kept).rstrip("\n") + "\n"
