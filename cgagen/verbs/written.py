"""What verbs write: checked before the work, and stdout left to it where it is one of them."""

import sys
from collections.abc import Iterable
from pathlib import Path

import click

from cgagen.outputs import Kind, check_outputs
from cgagen.places import move_stdout, put_stdout_back

STDOUT = 1


def check(
    outputs: Iterable[tuple[Path, Kind]], inputs: Iterable[Path] = (), force: bool = False
) -> None:
    """Refuse outputs as `check_outputs` does; and where one is stdout, keep all else from it.

    What the verb prints then comes on stderr, so that `-o /dev/stdout` gives a whole file.

    Raises:
        CgagenError: see `check_outputs`.
    """
    places = check_outputs(outputs, inputs, force)
    if any(place.descriptor == STDOUT for place in places):
        sys.stdout.flush()
        move_stdout()
        click.get_current_context().call_on_close(put_stdout_back)
