"""The tokenizer in the user's cache: one file that is right, or it is not used."""

import os
from pathlib import Path

from cgagen.errors import ToolchainError
from cgagen.files import digest
from cgagen.inputs import MIB, Kind, read_bytes_if_there

PACKAGE = "pbasic-tokenizer"
VERSION = "0.3.0"
TOKENIZER_SHA256 = "e17fce576f4fda9acc174bb96986059e878f4aaef1c9867b4d20680226cc2832"
"""Of `index.js` in that version, as npm delivers it. Ref: S3, measured."""

TOKENIZER = Kind(
    "the tokenizer",
    64 * MIB,
    ToolchainError,
    f"give a file of `npm pack {PACKAGE}@{VERSION}`, or its index.js",
)


def tokenizer_path() -> Path:
    """Return where `setup` puts the tokenizer, whether it is there or not."""
    base = os.environ.get("XDG_CACHE_HOME", "")
    # A relative path there is to be ignored, says the XDG Base Directory Specification.
    root = Path(base) if os.path.isabs(base) else Path.home() / ".cache"
    return root / "cgagen" / f"{PACKAGE}-{VERSION}" / "index.js"


def find_tokenizer() -> Path:
    """Return the tokenizer that this machine has, its hash checked.

    Raises:
        ToolchainError: there is none, or it is not the one that we know.
    """
    given = os.environ.get("CGAGEN_TOKENIZER")
    path = Path(given) if given else tokenizer_path()
    content = read_bytes_if_there(path, TOKENIZER)
    if content is None:
        if given:
            raise ToolchainError(
                f"CGAGEN_TOKENIZER names {path}, which is not there; "
                f"give the index.js of {PACKAGE} {VERSION}, or unset it and run `cgagen setup`"
            )
        raise ToolchainError(
            "Parallax's tokenizer is not on this machine yet; run `cgagen setup` once, or "
            "`cgagen setup --offline FILE` where there is no network"
        )
    if digest(content) != TOKENIZER_SHA256:
        mend = (
            "unset CGAGEN_TOKENIZER and run `cgagen setup`"
            if given
            else "run `cgagen setup` to fetch it again"
        )
        raise ToolchainError(
            f"{path} is not the tokenizer of {PACKAGE} {VERSION} (its hash is "
            f"{digest(content)[:12]}, not {TOKENIZER_SHA256[:12]}) and was not run; {mend}"
        )
    return path
