"""The tokenizer in the user's cache: one file that is right, or it is not used."""

import os
from pathlib import Path

from cgagen.caches import trouble_of, user_cache
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
    """Return where `setup` puts the tokenizer, whether it is there or not.

    Raises:
        ToolchainError: there is no home, and no other place was named.
    """
    root = user_cache()
    if root is None:
        raise ToolchainError(
            "this user has no home, where the tokenizer would be kept; set XDG_CACHE_HOME to a "
            "folder, or CGAGEN_TOKENIZER to the tokenizer's index.js"
        )
    return root / f"{PACKAGE}-{VERSION}" / "index.js"


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
    if not given:
        _refuse_strangers(path)
    return path


def _refuse_strangers(path: Path) -> None:
    """Refuse a tokenizer that others could exchange once its hash has been looked at.

    Raises:
        ToolchainError: others can write the file or its folder.
    """
    for one in (path.parent, path):
        try:
            trouble = trouble_of(one)
        except OSError as error:
            trouble = error.strerror or str(error)
        if trouble:
            raise ToolchainError(
                f"{one}: {trouble}, so the tokenizer in it was not run; remove the folder and run "
                "`cgagen setup`, or set XDG_CACHE_HOME to a folder of your own"
            )
