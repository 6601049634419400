"""The report as one page: everything in one file, nothing from anywhere else."""

from collections.abc import Mapping, Sequence
from typing import Any

import jinja2

from cgagen.firmware.render import shipped_templates
from cgagen.words import GENES, Situation, situation_name

TEMPLATE = "hil-report.html.jinja"

PAGE_MARK = '<meta name="generator" content="cgagen-hil-report-1">'
"""In the head of every page: whose it is."""

MARKS = {"PASS": "✓", "FAIL": "✗", "BLOCKED": "⊘", "UNPROVEN": "?", "NOT TRIED": "-"}
"""Beside every colour stands a sign."""

MS = 1_000_000


def page_text(report: Mapping[str, Any]) -> str:
    """Return the page of a report."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(shipped_templates()),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters |= {"ms": _ms, "words": _words, "digits": _digits}
    environment.globals |= {"marks": MARKS, "mark": PAGE_MARK}
    robots = [_shown(robot) for robot in report["robots"]]
    return environment.get_template(TEMPLATE).render(dict(report) | {"robots": robots})


def _shown(robot: Mapping[str, Any]) -> dict[str, Any]:
    """Return a robot with its tables laid out as they are drawn."""
    states = [row | _state_mark(row) for row in robot["states"]]
    limits = [row | {"cells": _step_marks(row["steps"])} for row in robot["boundaries"]]
    laid: dict[str, Any] = {"rows": [], "heads": []}
    if len(states) == GENES:
        laid["heads"] = [_words(situation_name(one, "target")) for one in Situation]
        laid["rows"] = [
            {
                "name": _words(situation_name(one, "object")),
                "cells": states[8 * one : 8 * one + 8],
            }
            for one in Situation
        ]
    return dict(robot) | {"states": states, "limits": limits, "grid": laid}


def _state_mark(row: Mapping[str, Any]) -> dict[str, str]:
    """Return how a state is drawn: a class, a sign, and words for those who cannot see them."""
    tried, agreed = row["readings"]
    looked, right = row["table"]
    if agreed < tried or right < looked:
        wrong = f"{tried - agreed} of {_digits(tried)} wrong" if agreed < tried else "wrong entry"
        return {"kind": "bad", "sign": "✗", "told": wrong}
    if tried:
        return {"kind": "good", "sign": "✓", "told": f"{_digits(tried)} agree"}
    if not row["reached"]:
        told = "entry right" if looked else "no reading"
        return {"kind": "none", "sign": "∅", "told": told}
    return {"kind": "open", "sign": "-", "told": "entry right" if looked else "not tried"}


def _step_marks(steps: Mapping[str, Sequence[int]]) -> list[dict[str, Any]]:
    cells = []
    for step, (tried, agreed) in steps.items():
        kind = "open" if not tried else "good" if tried == agreed else "bad"
        sign = {"open": "-", "good": "✓", "bad": "✗"}[kind]
        told = _digits(tried) if tried == agreed else f"{_digits(agreed)} of {_digits(tried)}"
        cells.append({"step": step, "kind": kind, "sign": sign, "told": told if tried else ""})
    return cells


def _ms(time_ns: int, digits: int = 1) -> str:
    """Return a time in milliseconds.

    >>> _ms(281_153_011)
    '281.2'
    """
    return f"{time_ns / MS:.{digits}f}"


def _words(name: str) -> str:
    """Return a name of ours as words.

    >>> _words("near_right")
    'near right'
    """
    return name.replace("_", " ").lower()


def _digits(number: int) -> str:
    r"""Return a number with thin spaces between its thousands, which screen readers leave alone.

    >>> _digits(70656)
    '70\u202f656'
    """
    return f"{number:,}".replace(",", "\u202f")
