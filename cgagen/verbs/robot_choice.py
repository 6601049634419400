"""Which robot a verb works with: the one that was named, or the one that belongs to a genome."""

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from cgagen.verbs.console import Console

IN_FIRMWARE = ("light", "masking", "prey_policy")
"""Options of the world that programs are built with: from the robot's file alone."""

if TYPE_CHECKING:
    from cgagen.genome import Genome
    from cgagen.robot import Robot


def robot_of(console: Console, genome: "Genome", path: Path, named: str | None) -> "Robot":
    """Return the robot of a genome, and note what is to be known of that choice.

    Args:
        console: for the note.
        genome: what `path` holds.
        path: a file, in a run or a build where the robot lies beside it.
        named: what `--robot` says.

    Raises:
        GenomeError: made for another kind of robot, or nothing says for which.
        CgagenError: the robot that is named, or the folder around the genome, cannot be.
    """
    from cgagen.genome import check_interface
    from cgagen.whose import match

    robot, home, said = match(genome, path, named)
    if robot.limits is not None:
        changed = check_interface(genome, robot.name, robot.interface, robot.digest)
        said = changed or said
    record = home.record if home else None
    other = sorted({*IN_FIRMWARE} & {*dict(record.settings.world)}) if record else []
    for one in (said, left_out_text(other)):
        if one:
            console.note(f"note: {one}")
    return robot


def left_out_text(names: Iterable[str]) -> str | None:
    """Return what is said of options of a run that its programs do not follow; None for none."""
    words = ", ".join(name.replace("_", " ") for name in names)
    return f"{words}: as the robot's file has it, not the run" if words else None
