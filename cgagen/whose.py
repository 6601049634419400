"""Whose a genome is: a run folder and a build folder hold the robot that theirs were made for.

A genome names its robot, and a name is all that a file can be held to. Beside it lies the robot
itself, `1-predator.toml` in a run and `robot.toml` in a build, with its digest on record. So no
verb asks for `--robot` where the genome lies in such a folder, and a robot of one's own is as
good as those that ship.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from cgagen.build.record import RECORD_FILE, ROBOT_FILE
from cgagen.build.record import read_record as read_build
from cgagen.errors import CgagenError, FolderError, GenomeError, RobotError
from cgagen.files import digest
from cgagen.genome import Genome, check_interface
from cgagen.inputs import BUILD_FILE, read_text
from cgagen.robot import Arena, Robot, load_robot, shipped
from cgagen.robot.reader import parse_arena, parse_robot
from cgagen.run import RunRecord, read_record
from cgagen.run.folder import RECORD
from cgagen.words import Role

PREDATOR_FILE, PREY_FILE, ARENA_FILE = "1-predator.toml", "1-prey.toml", "1-arena.toml"


@dataclass(frozen=True, slots=True)
class Home:
    """A folder that says whose the genomes in it are.

    Attributes:
        file: of the robot.
        robot: the one that a genome in there is for.
        record: of the run; None in a build.
        prey: the run's; None in a build.
        arena: likewise.
    """

    file: Path
    robot: Robot
    record: RunRecord | None = None
    prey: Robot | None = None
    arena: Arena | None = None


class Match(NamedTuple):
    """A genome's robot.

    Attributes:
        robot: the one that was named, or the folder's, or the one that ships.
        home: where the genome lies; None where no run or build of a robot is around it.
        note: what the user should know of the choice; None for nothing.
    """

    robot: Robot
    home: Home | None
    note: str | None


def home_of(path: Path) -> Home | None:
    """Return the run or the build that a file lies in; None where it lies in none.

    Args:
        path: of a genome or a trace; a link counts as lying where it leads to, too.

    Raises:
        RunError: a run whose record or inputs have been changed.
        FolderError: a build likewise.
        RobotError: its robot's file cannot be.
    """
    for folder in dict.fromkeys((path.parent, path.resolve().parent)):
        if (folder / RECORD).is_file():
            return _run(folder)
        if (folder / RECORD_FILE).is_file():
            return _build(folder)
    return None


def match(genome: Genome, path: Path, named: str | None = None) -> Match:
    """Return the robot that a genome is to drive.

    Args:
        genome: a predator's.
        path: its file.
        named: a robot's name or file, which counts before everything else.

    Raises:
        GenomeError: nothing says which robot it is.
        CgagenError: see `home_of`, where no robot is named.
    """
    if named:
        try:
            home = home_of(path)
        except CgagenError:  # what was named does not need the folder
            home = None
        robot = load_robot(named)
        return Match(robot, home, _differs(genome, robot, named, home))
    try:
        home = home_of(path)
    except RobotError as error:
        # the folder's own file is held to its digest, so what is to be changed is a copy
        raise RobotError(
            f"{error}; change a copy of that file, and name the copy with --robot"
        ) from error
    except CgagenError as error:
        raise type(error)(f"{error}; or name the robot with --robot") from error
    says_nothing = genome.interface is None
    if home is not None and (says_nothing or home.robot.name == genome.robot):
        return Match(home.robot, home, None)
    if genome.robot in shipped("robot"):
        other = f"{path}: is for {genome.robot}; {home.file} is {home.robot.name}" if home else None
        return Match(load_robot(genome.robot), None, other)
    around = f"{home.file} is {home.robot.name}" if home else "no run or build is around it"
    raise GenomeError(
        f"{path}: robot: {genome.robot!r} does not ship with cgagen, and {around}; "
        "pass its file with --robot FILE"
    )


def _differs(genome: Genome, robot: Robot, named: str, home: Home | None) -> str | None:
    """Return the note that a named robot is not the one beside the genome."""
    if home is None or home.robot.digest == robot.digest or home.robot.role is not robot.role:
        return None
    try:
        if check_interface(genome, robot.name, robot.interface, robot.digest):
            return None  # whoever uses the genome says that, and it says more
    except GenomeError:
        return None  # likewise
    return f"--robot {named} is not the robot in {home.file}, which the genome lies beside"


def _run(folder: Path) -> Home:
    record = read_record(folder)
    inputs = record.inputs
    return Home(
        folder / PREDATOR_FILE,
        parse_robot(inputs.predator, str(folder / PREDATOR_FILE)),
        record,
        parse_robot(inputs.prey, str(folder / PREY_FILE)),
        parse_arena(inputs.arena, str(folder / ARENA_FILE)),
    )


def _build(folder: Path) -> Home | None:
    """Return a build of a predator; a prey's has no genome, and says nothing about one."""
    record, file = read_build(folder), folder / ROBOT_FILE
    try:
        text, wanted = read_text(file, BUILD_FILE), record["files"][ROBOT_FILE]
    except (KeyError, TypeError) as error:
        raise FolderError(
            f"{folder}: {RECORD_FILE} and {ROBOT_FILE} do not fit ({error}); build it again"
        ) from error
    if digest(text) != wanted:
        raise FolderError(
            f"{file}: is not the robot that the folder was built for; put it back, or build the "
            "folder again"
        )
    robot = parse_robot(text, str(file))
    if robot.role is not Role.PREDATOR:
        return None
    return Home(file, robot)
