"""The variables of the environment, as the help of every verb that heeds them shows them."""

TOOLCHAIN = """\b
Environment:
  CGAGEN_NODE       the Node program to use, before PATH
  CGAGEN_TOKENIZER  the tokenizer's index.js to use, instead of the cache
  XDG_CACHE_HOME    where caches live (default: ~/.cache)
"""
