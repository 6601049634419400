"""The shape of a `build.json`: every key that somebody looks at, with the kind of its value.

A record that a person, a disk or a merge has changed is refused here, in one sentence, so that
nobody behind has to ask whether a name is a name.
"""

from collections.abc import Mapping
from typing import Any

from cgagen.shown import short, shown

_ROBOT = {"name": str, "role": str, "digest": str, "interface": str}
_GENOME = {"digest": str, "robot": str}
_PROGRAM = {
    "source": str,
    "source_digest": str,
    "image": str,
    "image_digest": str,
    "model": str,
    "slot": int,
    "blocks": list,
}
_TOP = {"robot": dict, "programs": dict, "files": dict, "templates": dict, "tokenizer": dict}

CHIPS = ("main", "locomotion")

_WORDS = {str: "a text", int: "a whole number", list: "a list", dict: "a table"}


def trouble_of(record: Mapping[str, Any]) -> str:
    """Return what is wrong with the shape of a record, as the end of a sentence; "" for nothing.

    >>> trouble_of({"robot": 3})
    'robot is 3, not a table'
    """
    trouble = _wrong(record, _TOP, "") or _wrong(record["robot"], _ROBOT, "robot.")
    trouble = trouble or _wrong(record["programs"], dict.fromkeys(CHIPS, dict), "programs.")
    if trouble:
        return trouble
    for chip in CHIPS:
        program, path = record["programs"][chip], f"programs.{chip}."
        trouble = trouble or _wrong(program, _PROGRAM, path)
        trouble = trouble or _strange_names(program, path)
    if not trouble and record.get("genome") is not None:
        genome = record["genome"]
        trouble = _wrong({"genome": genome}, {"genome": dict}, "")
        trouble = trouble or _wrong(genome, _GENOME, "genome.")
    return trouble or _other_than_texts(record["files"], "files")


def _wrong(table: Mapping[str, Any], kinds: Mapping[str, type], path: str) -> str:
    for key, kind in kinds.items():
        if key not in table:
            return f"{path}{key} is missing"
        if type(table[key]) is not kind:
            return f"{path}{key} is {shown(table[key])}, not {_WORDS[kind]}"
    return ""


def _strange_names(program: Mapping[str, Any], path: str) -> str:
    """Return what is wrong with names: a build's files lie in its folder."""
    for key in ("source", "image"):
        name = program[key]
        if not name or name.startswith(".") or not name.isprintable() or set("/\\") & set(name):
            return f"{path}{key} is {shown(name)}, which is no name of a file of this folder"
    blocks = program["blocks"]
    texts = all(isinstance(one, str) and set(one) <= set("+0123") for one in blocks)
    return "" if texts else f"{path}blocks is {shown(blocks)}, not the use of every byte"


def _other_than_texts(table: Mapping[str, Any], path: str) -> str:
    for key, value in table.items():
        if not isinstance(value, str):
            return f"{path}.{short(key)} is {shown(value)}, not a text"
    return ""
