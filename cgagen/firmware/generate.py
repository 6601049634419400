"""Robot and genome -> the sources of both Stamps, as values."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from cgagen.bench_protocol import VERSION, Banner, banner_text, plain
from cgagen.errors import GenomeError
from cgagen.files import digest
from cgagen.firmware.locomotion_words import locomotion_words
from cgagen.firmware.main_words import main_words
from cgagen.firmware.render import Renderer
from cgagen.firmware.sandbox import Rendered
from cgagen.firmware.timing import check_timing
from cgagen.genome import Genome
from cgagen.robot.values import Robot
from cgagen.words import Role

MAIN_FILE = "main.bsp"
LOCOMOTION_FILE = "locomotion.bs2"

DIGEST_DIGITS = 8
"""Of a SHA-256 in a banner: enough to tell builds apart, few enough to read aloud. Choice."""

DIGEST_BLANK = "-" * DIGEST_DIGITS
"""What stands in a source's own digest while that is computed."""

MAIN_TEMPLATES = {Role.PREDATOR: "predator-main.bsp.j2", Role.PREY: "prey-main.bsp.j2"}
LOCOMOTION_TEMPLATE = "locomotion.bs2.j2"


@dataclass(frozen=True, slots=True)
class Program:
    """The PBASIC of one Stamp.

    Attributes:
        file: its name in a build folder.
        chip: "main" or "locomotion".
        model: of the Stamp.
        source: the text, ASCII with line feeds.
        banner: what it says of itself at reset.
        origins: file and line of the template that each line of the text comes from.
    """

    file: str
    chip: str
    model: str
    source: str
    banner: Banner
    origins: tuple[tuple[str, int], ...] = field(default=(), repr=False, compare=False)


@dataclass(frozen=True, slots=True)
class Firmware:
    """Both programs, and the templates that they were made of.

    Attributes:
        programs: main controller, locomotion controller.
        templates: (template, SHA-256 of its text), by name.
        notes: what a user should know of templates of their own.
    """

    programs: tuple[Program, Program]
    templates: tuple[tuple[str, str], ...]
    notes: tuple[str, ...] = ()

    @property
    def files(self) -> dict[str, str]:
        """The sources by file name."""
        return {program.file: program.source for program in self.programs}

    @property
    def digest(self) -> str:
        """SHA-256 of names and contents."""
        return digest("".join(f"{name}\n{text}\n" for name, text in sorted(self.files.items())))


def generate(robot: Robot, genome: Genome | None = None, templates: Path | None = None) -> Firmware:
    """Return the programs of both Stamps.

    Args:
        robot: predator or prey.
        genome: the predator's table; None for a prey, which has none.
        templates: a folder whose files come before the templates of cgagen.

    Raises:
        GenomeError: a predator without a genome, or a prey with one.
        RobotError: the robot's servos or movements cannot be served in time.
        TemplateError: a template asks for a word that there is not, or is no Jinja.
    """
    _check_role(robot, genome)
    check_timing(robot)
    renderer = Renderer(templates)
    content = genome.digest if genome else robot.digest
    common: dict[str, Any] = {
        "robot_name": plain(robot.name),
        "role": str(robot.role),
        "digest_blank": DIGEST_BLANK,
        "genome_digest": content[:DIGEST_DIGITS],
    }
    main = _program(
        renderer,
        MAIN_TEMPLATES[robot.role],
        (MAIN_FILE, "main", robot.main.model),
        common | main_words(robot, genome),
    )
    locomotion = _program(
        renderer,
        LOCOMOTION_TEMPLATE,
        (LOCOMOTION_FILE, "locomotion", robot.locomotion.model),
        common | locomotion_words(robot, genome),
    )
    return Firmware((main, locomotion), renderer.used(), renderer.notes())


def _check_role(robot: Robot, genome: Genome | None) -> None:
    if robot.role is Role.PREDATOR and genome is None:
        raise GenomeError(
            f"{robot.name}: a predator hunts by a genome; give one, the best.genome of a run"
        )
    if robot.role is Role.PREY and genome is not None:
        raise GenomeError(
            f"{robot.name}: a prey acts by the reflex of its file and takes no genome; leave it out"
        )


def source_digest(source: str, shown: str) -> str:
    """Return the digest of a source, computed with the digest that it shows left blank.

    Args:
        source: the text.
        shown: the digest in its banner; a true one is returned unchanged.

    >>> source_digest("' Source: 12345678", "12345678")
    '893f6f2f'
    """
    return digest(source.replace(shown, DIGEST_BLANK))[:DIGEST_DIGITS]


def _program(
    renderer: Renderer, template: str, place: tuple[str, str, str], words: dict[str, Any]
) -> Program:
    file, chip, model = place
    blank = Banner(VERSION, chip, words["robot_name"], words["genome_digest"], DIGEST_BLANK)

    def rendered(source_digest: str) -> tuple[Banner, Rendered]:
        banner = blank._replace(source=source_digest)
        extra = {"source_digest": source_digest, "banner": banner_text(banner)}
        return banner, renderer.render(template, words | extra)

    banner, made = rendered(digest(rendered(DIGEST_BLANK)[1].text)[:DIGEST_DIGITS])
    return Program(file, chip, model, made.text, banner, tuple(made.origins))
