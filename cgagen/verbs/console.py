"""What every verb is given: where results and notes go, and in which form."""

import json
import os
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import Any, Concatenate, ParamSpec, Self, TypeVar

import click

from cgagen.caches import TROUBLE
from cgagen.shown import printable
from cgagen.verbs.rules import check_options

P = ParamSpec("P")
R = TypeVar("R")


@dataclass(frozen=True, slots=True)
class Console:
    """The global options of one call.

    Attributes:
        as_json: results are JSON instead of text.
        progress: progress may be drawn on stderr (a terminal, and not switched off).
        color: colours may be used.
        verbose: say more.
        quiet: say results only.
        no_progress: no progress was asked for, not even a line now and then.
    """

    as_json: bool = False
    progress: bool = False
    color: bool = True
    verbose: bool = False
    quiet: bool = False
    no_progress: bool = False

    @classmethod
    def of_process(cls) -> Self:
        """Return what holds where no option says anything else."""
        return cls(progress=sys.stderr.isatty(), color="NO_COLOR" not in os.environ)

    def result(self, data: Any, text: str) -> None:
        """Print a result on stdout: `data` with `--json`, otherwise `text`."""
        click.echo(json_line(data) if self.as_json else printable(text), color=self.color)

    def note(self, text: str) -> None:
        """Print a note on stderr, unless the user wants results only."""
        if not self.quiet:
            click.echo(printable(text), err=True, color=self.color)


def json_line(data: Any) -> str:
    r"""Return a result as JSON of printable ASCII; no character of a string reaches a terminal.

    >>> json_line({"name": "\x1b[31m\x7f"})
    '{"name": "\\u001b[31m\\u007f"}'
    """
    return json.dumps(data).replace("\x7f", r"\u007f")


def with_console(
    function: Callable[Concatenate[Console, P], R],
) -> Callable[P, R]:
    """Hand the call's `Console` to a verb as its first argument, once its options go together."""

    @wraps(function)
    def called(*args: P.args, **kwargs: P.kwargs) -> R:
        context = click.get_current_context()
        check_options(context)
        console: Console = context.obj
        TROUBLE.tell = console.note if console.verbose else None
        return function(console, *args, **kwargs)

    return called
