"""What every verb is given: where results and notes go, and in which form."""

import json
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Concatenate, ParamSpec, TypeVar

import click

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
    """

    as_json: bool = False
    progress: bool = False
    color: bool = True
    verbose: bool = False
    quiet: bool = False

    def result(self, data: Any, text: str) -> None:
        """Print a result on stdout: `data` with `--json`, otherwise `text`."""
        click.echo(json.dumps(data) if self.as_json else text, color=self.color)

    def note(self, text: str) -> None:
        """Print a note on stderr, unless the user wants results only."""
        if not self.quiet:
            click.echo(text, err=True, color=self.color)


def with_console(
    function: Callable[Concatenate[Console, P], R],
) -> Callable[P, R]:
    """Hand the call's `Console` to a verb as its first argument."""
    return click.pass_obj(function)


def with_json(command: click.Command) -> click.Command:
    """Give a verb, and its own verbs, the global `--json` at its end, too: where one looks first.

    A verb with an option of that name keeps its own.
    """
    if isinstance(command, click.Group):
        for one in command.commands.values():
            with_json(one)
    elif not any("--json" in one.opts for one in command.params):
        command.params.append(
            click.Option(
                ["--json"],
                is_flag=True,
                expose_value=False,
                callback=_wants_json,
                help="The result as JSON on stdout.",
            )
        )
    return command


def _wants_json(context: click.Context, _option: click.Parameter, wanted: bool) -> None:
    if wanted and isinstance(context.obj, Console):
        context.obj = replace(context.obj, as_json=True)
