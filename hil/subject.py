"""What is on trial: a robot, its genome, and the programs that are to be in its chips."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from cgagen.bench_protocol import VERSION, Banner, plain
from cgagen.build import Build, read_record
from cgagen.build.checked import changed_files
from cgagen.build.record import BENCH_FILE, GENOME_FILE, ROBOT_FILE, flags_of
from cgagen.errors import FolderError, MismatchError, RigError
from cgagen.genome import Genome, load
from cgagen.inputs import BUILD_FILE, read_bytes
from cgagen.robot import Robot, load_robot
from cgagen.stamp.chips import chip
from cgagen.stamp.image import Image
from cgagen.words import COMMANDS, Role

CHIPS = ("main", "locomotion")


@dataclass(frozen=True)
class Subject:
    """A robot's firmware, with what it is to agree with.

    Attributes:
        robot: its thresholds and wiring are what the firmware is compared with.
        genome: the predator's; None for a prey.
        images: what is executed, by chip.
        sources: PBASIC by chip; for line numbers, and judged against the images.
        files: name of each source.
        source_digests: of the sources as they were built, which the banners say.
        where: what messages call it.
        robot_edited: the robot's file is not the one that the build was made from.
    """

    robot: Robot
    genome: Genome | None
    images: dict[str, Image]
    sources: dict[str, str] = field(repr=False)
    files: dict[str, str]
    source_digests: dict[str, str]
    where: str
    robot_edited: bool = False

    @property
    def role(self) -> Role:
        """Predator or prey."""
        return self.robot.role

    @property
    def origin_digest(self) -> str:
        """Digest of what decides: the genome's, or a prey's file's."""
        return self.genome.digest if self.genome else self.robot.digest

    @property
    def genome_digest(self) -> str:
        """The 8 digits that the banners say."""
        return self.origin_digest[:8]

    @property
    def plain_name(self) -> str:
        """The robot's name as its programs say it."""
        return plain(self.robot.name)

    def banner(self, chip_name: str) -> Banner:
        """Return what a controller has to say of itself, by robot, genome and `build.json`."""
        return Banner(
            VERSION,
            chip_name,
            self.plain_name,
            self.genome_digest,
            self.source_digests[chip_name],
        )

    def genome_for_hunt(self) -> Genome:
        """Return the genome, which the simulator needs to hunt, too.

        Raises:
            RigError: a prey's build, which has none.
        """
        if self.genome is None:
            raise RigError(f"{self.where}: a build without genome; name one of a predator")
        return self.genome

    def movement(self, command: int) -> str:
        """Return a command's name."""
        return str(COMMANDS[self.role][command])


def subject_of(build: Build, where: str) -> Subject:
    """Return a build as it was just made."""
    programs = dict(zip(CHIPS, build.programs, strict=True))
    return Subject(
        build.robot,
        build.genome,
        {name: built.image for name, built in programs.items()},
        {name: built.program.source for name, built in programs.items()},
        {name: built.program.file for name, built in programs.items()},
        {name: built.program.banner.source for name, built in programs.items()},
        where,
    )


def read_subject(folder: Path) -> Subject:
    """Return what lies in a build folder, changed by hand or not.

    Raises:
        FolderError: the folder is no build.
        CgagenError: its genome or its robot is not readable.
    """
    record = read_record(folder)
    try:
        programs = {name: record["programs"][name] for name in CHIPS}
        images = {name: _image(folder, row) for name, row in programs.items()}
        sources = {
            name: read_bytes(folder / row["source"], BUILD_FILE).decode("ascii", "replace")
            for name, row in programs.items()
        }
        files = {name: row["source"] for name, row in programs.items()}
        digests = {name: str(row["source_digest"]) for name, row in programs.items()}
    except (KeyError, ValueError) as error:
        raise FolderError(
            f"{folder}: {BENCH_FILE} and the files of build.json do not fit ({error}); "
            "build it again"
        ) from error
    robot = load_robot(str(folder / ROBOT_FILE))
    genome = load(folder / GENOME_FILE) if robot.role is Role.PREDATOR else None
    edited = ROBOT_FILE in changed_files(folder, record)
    return Subject(robot, genome, images, sources, files, digests, str(folder), edited)


def held(subject: Subject, robot: Robot | None, genome: Genome | None) -> Subject:
    """Return a build, held against what was named beside it.

    Args:
        subject: out of a build folder.
        robot: that was named; None for none.
        genome: likewise.

    Raises:
        MismatchError: the build is another robot's, or holds another genome.
    """
    words = unlike(subject, robot, genome)
    if words:
        raise MismatchError(f"{subject.where}: {words}")
    return subject


def unlike(subject: Subject, robot: Robot | None, genome: Genome | None) -> str:
    """Return in what a build is not of what was named beside it; "" where it is. See `held`."""
    if robot is not None and not alike(robot, subject.robot):
        return (
            f"is a build for {subject.robot.name} ({subject.robot.digest[:8]}), and the robot "
            f"that was named beside it is {robot.name} ({robot.digest[:8]}); build it for that "
            "one, or name one of them alone"
        )
    digest = subject.genome.digest if subject.genome else None
    if genome is not None and genome.digest != digest:
        ours = f"holds genome {digest[:8]}" if digest else f"is a {subject.role}'s, without genome"
        return (
            f"{ours}, and the genome that was named beside it is {genome.digest[:8]}; build that "
            "one, or name one of them alone"
        )
    return ""


def alike(one: Robot, other: Robot) -> bool:
    """Whether two robots are the same but for the comments of their files."""
    return replace(one, text="", digest="") == replace(other, text="", digest="")


def _image(folder: Path, row: Mapping[str, Any]) -> Image:
    data = read_bytes(folder / row["image"], BUILD_FILE)
    return Image(chip(row["model"]), data, flags_of(row["blocks"]), row["slot"])
