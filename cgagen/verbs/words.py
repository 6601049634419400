"""How the words of a command line are taken: verbs, choices, and options that stand anywhere."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from cgagen.near import did_you_mean
from cgagen.verbs.console import Console

NESTED = {
    "centre": "robot centre",
    "center": "robot centre",
    "move": "robot move",
    "sensors": "robot sensors",
    "record": "trace record",
    "convert": "trace convert",
    "show": "trace show",
}
"""Verbs of verbs, for who leaves the first word out."""


class Words(click.Choice[str]):
    """One of some words; for another one, the likeliest is named."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the word, or a usage error."""
        try:
            return super().convert(value, param, ctx)
        except click.BadParameter as error:
            meant = did_you_mean(str(value), map(str, self.choices))
            said = f"{error.message.removesuffix('.')}{meant}."
            raise click.BadParameter(said, ctx, param) from error


class Verbs(click.Group):
    """Verbs, with a hint for one that there is not, and for an option that stands before it."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the verbs in the order in which they were written."""
        return list(self.commands)

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the verb that a line begins with."""
        word = args[0]
        if self.get_command(ctx, word) is None and not word.startswith("-"):
            ctx.fail(f"no such verb: {word}{self._hint(ctx, word)}")
        return super().resolve_command(ctx, args)

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Take the options before the verb."""
        try:
            return super().parse_args(ctx, args)
        except click.NoSuchOption as error:
            said = f"{error.format_message().removesuffix('.')}; a verb's options stand behind it"
            raise click.UsageError(said, ctx) from error

    def _hint(self, ctx: click.Context, word: str) -> str:
        known = self.list_commands(ctx)
        if ctx.parent is None and word in NESTED:
            return f" (did you mean {NESTED[word]}?)"
        if ctx.parent is None and _is_file(word):
            return f"; to be told what that file is, say: cgagen info {word}"
        return did_you_mean(word, known) or f"; there are {', '.join(known)}"


def _is_file(word: str) -> bool:
    try:
        return Path(word).exists()
    except (OSError, ValueError):
        return False


def _json(console: Console) -> Console:
    return replace(console, as_json=True)


def _no_progress(console: Console) -> Console:
    return replace(console, progress=False, no_progress=True)


def _no_color(console: Console) -> Console:
    return replace(console, color=False)


def _verbose(console: Console) -> Console:
    return replace(console, verbose=True)


def _quiet(console: Console) -> Console:
    return replace(console, quiet=True, progress=False)


ANYWHERE: tuple[tuple[tuple[str, ...], Callable[[Console], Console], str], ...] = (
    (("--json",), _json, "The result as JSON on stdout."),
    (("--no-progress",), _no_progress, "No progress on stderr."),
    (("--no-color",), _no_color, "No colours (also: NO_COLOR)."),
    (("-v", "--verbose"), _verbose, "Say more; show tracebacks."),
    (("-q", "--quiet"), _quiet, "Say results only: no notes, no progress, no `next:`."),
)
"""The options that may stand before a verb, behind it, and between a verb and its own verb."""


def with_anywhere(command: click.Command, *, all_shown: bool = False) -> click.Command:
    """Give a verb, and its own verbs, the options that may stand anywhere.

    A verb with an option of such a name keeps its own. Their help shows `--json` alone, where one
    looks for it; all of them stand in the help of `cgagen`.
    """
    for names, change, told in ANYWHERE:
        taken = {name for one in command.params for name in (*one.opts, *one.secondary_opts)}
        free = [name for name in names if name not in taken]
        if free:
            command.params.append(_option(free, change, told, all_shown or "--json" in names))
    if isinstance(command, click.Group):
        for one in command.commands.values():
            with_anywhere(one)
    return command


def _option(
    names: list[str], change: Callable[[Console], Console], told: str, is_shown: bool
) -> click.Option:
    def heard(context: click.Context, _option: click.Parameter, wanted: bool) -> None:
        if wanted and isinstance(context.obj, Console):
            context.obj = change(context.obj)

    return click.Option(
        [*names, f"anywhere_{change.__name__.strip('_')}"],
        is_flag=True,
        expose_value=False,
        callback=heard,
        hidden=not is_shown,
        help=told,
    )
