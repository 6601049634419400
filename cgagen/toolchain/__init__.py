"""Where Node and Parallax's tokenizer are on this machine, and how they get there.

The tokenizer is npm's `pbasic-tokenizer` 0.3.0 (MIT, Parallax Inc.). It is not part of this
project: `setup` fetches it with npm from a lock file of ours, checks its hash and keeps it in
the user's cache. Three variables of the environment override what is looked up:

* ``CGAGEN_NODE``: the Node program to use.
* ``CGAGEN_TOKENIZER``: the tokenizer's `index.js`; its hash must be the known one.
* ``XDG_CACHE_HOME``: where caches live; `~/.cache` otherwise.
"""

from cgagen.toolchain.cache import (
    PACKAGE,
    TOKENIZER_SHA256,
    VERSION,
    find_tokenizer,
    tokenizer_path,
)
from cgagen.toolchain.fetch import setup
from cgagen.toolchain.node import OLDEST_NODE, TESTED_NODES, Node, find_node

__all__ = [
    "OLDEST_NODE",
    "PACKAGE",
    "TESTED_NODES",
    "TOKENIZER_SHA256",
    "VERSION",
    "Node",
    "find_node",
    "find_tokenizer",
    "setup",
    "tokenizer_path",
]
