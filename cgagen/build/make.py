"""The build as a value: generated, compiled, measured, described."""

import json
import tempfile
from dataclasses import dataclass
from pathlib import Path

from cgagen.build.bench import bench_text
from cgagen.build.record import (
    BENCH_FILE,
    GENOME_FILE,
    MEMORY_FILE,
    RECORD_FILE,
    ROBOT_FILE,
    WIRING_FILE,
    record_of,
)
from cgagen.build.wiring import wiring_text
from cgagen.errors import SourceError, StorageError
from cgagen.files import write_text
from cgagen.firmware import Firmware, Program, generate
from cgagen.genome import Genome, check_interface, to_text
from cgagen.memory import MemoryReport, report
from cgagen.robot.values import Robot
from cgagen.stamp.image import Image
from cgagen.tokenizer import Tokenizer

FREE_EEPROM_PERCENT = 20.0
FREE_RAM_BYTES = 2
"""What each program leaves for whoever changes it. Choice."""


@dataclass(frozen=True)
class BuiltProgram:
    """One program, compiled.

    Attributes:
        program: source and banner.
        image: what is sent to the chip.
        memory: what it takes of the chip.
    """

    program: Program
    image: Image
    memory: MemoryReport

    @property
    def image_file(self) -> str:
        """Name of the image in a build folder."""
        return Path(self.program.file).with_suffix(".bin").name


@dataclass(frozen=True)
class Build:
    """Both programs and what they were made of.

    Attributes:
        robot: whose they are.
        genome: the predator's; None for a prey.
        firmware: the sources.
        programs: main controller, locomotion controller.
        note: what the user should know about genome and robot; None for nothing.
    """

    robot: Robot
    genome: Genome | None
    firmware: Firmware
    programs: tuple[BuiltProgram, BuiltProgram]
    note: str | None

    def files(self) -> dict[str, bytes]:
        """Return the content of the build folder by file name; the same build, the same bytes."""
        files: dict[str, bytes] = {}
        for built in self.programs:
            files[built.program.file] = built.program.source.encode("ascii")
        for built in self.programs:
            files[built.image_file] = built.image.eeprom
        texts = [built.memory.to_text() for built in self.programs]
        files[MEMORY_FILE] = "\n\n".join(texts).encode()
        files[WIRING_FILE] = wiring_text(self.robot).encode()
        files[BENCH_FILE] = bench_text(self.robot).encode()
        files[ROBOT_FILE] = self.robot.text.encode()
        if self.genome is not None:
            files[GENOME_FILE] = to_text(self.genome).encode()
        record = record_of(self.robot, self.genome, self.firmware, files, self._compiled())
        files[RECORD_FILE] = (json.dumps(record, indent=1, ensure_ascii=False) + "\n").encode()
        return files

    def _compiled(self) -> list[tuple[Program, str, Image, MemoryReport]]:
        return [
            (built.program, built.image_file, built.image, built.memory) for built in self.programs
        ]


def make_build(
    robot: Robot,
    genome: Genome | None,
    tokenizer: Tokenizer,
    templates: Path | None = None,
) -> Build:
    """Generate, compile and measure both programs; nothing is written.

    Args:
        robot: predator or prey.
        genome: the predator's; None for a prey.
        tokenizer: compiles the sources.
        templates: a folder whose files come before the templates of cgagen.

    Raises:
        GenomeError: a predator without a genome, a prey with one, or one for another robot.
        RobotError: the robot's servos or movements cannot be served in time.
        TemplateError: see `cgagen.firmware.generate`.
        SourceError: the tokenizer refuses a source, or a source is not ASCII.
        BudgetError: a program leaves too little of its chip.
        ToolchainError: there is no tokenizer.
    """
    note = None
    if genome is not None and robot.limits is not None:
        note = check_interface(genome, robot.name, robot.interface, robot.digest)
    firmware = generate(robot, genome, templates)
    main, locomotion = (_compiled(program, tokenizer) for program in firmware.programs)
    return Build(robot, genome, firmware, (main, locomotion), note)


def _compiled(program: Program, tokenizer: Tokenizer) -> BuiltProgram:
    try:
        compiled = tokenizer.compile(program.source, program.file)
        if compiled.project_files:
            raise SourceError(
                f"{program.file}: its $STAMP line names {', '.join(compiled.project_files)}, and a "
                "build has one program for each chip; leave them out of the template"
            )
    except SourceError as error:
        raise _located(program, error) from error
    memory = report(compiled)
    memory.check(FREE_EEPROM_PERCENT, FREE_RAM_BYTES)
    return BuiltProgram(program, compiled.image, memory)


def _located(program: Program, error: SourceError) -> SourceError:
    """Return a refusal with the template's line, and the place where the text was left."""
    try:
        path = Path(tempfile.mkdtemp(prefix="cgagen-refused-")) / program.file
        write_text(path, program.source)
        left = f"the text is left in {path}"
    except (OSError, StorageError):
        left = "the text could not be left anywhere"
    origin = ""
    if error.line is not None and 1 <= error.line <= len(program.origins):
        file, line = program.origins[error.line - 1]
        origin = f"line {error.line} comes from {file}:{line}, and " if file else ""
    return SourceError(
        f"{error}\n{origin}{left}",
        code=error.code,
        line=error.line,
        column=error.column,
        length=error.length,
    )
