"""How a run is watched: bars on a terminal, a line every ten seconds elsewhere, or nothing."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from cgagen.verbs.console import Console

if TYPE_CHECKING:
    from cgagen.run import Progress

LINE_EVERY_S = 10.0
"""choice: a log of a full trial stays a few lines long."""


@contextmanager
def watch(console: Console, trials: int, wanted: bool) -> Iterator[Callable[["Progress"], None]]:
    """Give an observer for `cgagen.run`, and tidy the terminal at the end.

    Args:
        console: where to, and whether it is a terminal.
        trials: how many there are.
        wanted: False for no progress at all.
    """
    if not wanted:
        yield lambda progress: None
    elif console.progress:
        with _bars(console, trials) as observe:
            yield observe
    else:
        yield _lines(console, trials)


def words_of(progress: "Progress") -> str:
    """Return mean fitness, rate and time left as a user reads them."""
    left_s = round(progress.seconds_left)
    left = f"{left_s} s" if left_s < 120 else f"{left_s // 60} min"
    return (
        f"mean {progress.mean:6.1f}, {progress.steps_per_second / 1e6:5.1f} M steps/s, {left} left"
    )


def _lines(console: Console, trials: int) -> Callable[["Progress"], None]:
    """Return an observer that prints a plain line now and then."""
    told_at = time.monotonic()

    def observe(progress: "Progress") -> None:
        nonlocal told_at
        if time.monotonic() - told_at < LINE_EVERY_S:
            return
        told_at = time.monotonic()
        trial = f"trial {progress.trial}, " if trials > 1 else ""
        console.note(
            f"{trial}generation {progress.generation} of {progress.generations}: "
            f"{words_of(progress)}"
        )

    return observe


@contextmanager
def _bars(console: Console, trials: int) -> Iterator[Callable[["Progress"], None]]:
    """Draw a bar per trial on stderr."""
    from rich.console import Console as Terminal
    from rich.progress import BarColumn, TaskID, TextColumn
    from rich.progress import Progress as Bars

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.completed:.0f}/{task.total:.0f}"),
        TextColumn("{task.fields[words]}"),
    )
    tasks: dict[int, TaskID] = {}
    with Bars(*columns, console=Terminal(stderr=True, no_color=not console.color)) as bars:

        def observe(progress: "Progress") -> None:
            if progress.trial not in tasks:
                name = f"trial {progress.trial}" if trials > 1 else "generation"
                total = progress.generations
                tasks[progress.trial] = bars.add_task(name, total=total, words="")
            bars.update(
                tasks[progress.trial],
                completed=progress.generation,
                words=words_of(progress),
            )

        yield observe
