"""The error tree. Every leaf is one sentence: what is wrong, where, and what to do.

::

    CgagenError                 anything a user can mend; the CLI prints the sentence and exits
     +-- RobotError         3   a robot or arena file says something that cannot be
     +-- MeasurementError   3   a table of measurements that cannot be read or used
     +-- GenomeError        3   a genome file that is no genome, or not for this robot
     +-- RunError           3   a run folder that cannot be started or continued, and why
     +-- TemplateError      3   a template needs a word that the context does not have
     +-- FolderError        3   an output that would overwrite what is not ours
     |    +-- SamePlaceError  2   two outputs, or an output and an input, at one place
     +-- ImageError         3   bytes that are not the image of a Stamp
     +-- BudgetError        3   a program that does not fit its chip with the reserve asked for
     +-- BenchError         3   a bench file that says something that cannot be
     |    +-- ContentionError   two drivers hold one wire at different levels
     +-- TraceError         3   a trace that cannot be read, or is not of this robot
     +-- ReadingError       3   a reading that is none of the robot: other sensors, other counts
     +-- SymbolError        3   a name that a program does not have
     +-- ExecutionError     3   a program that does what no document says what it does
     +-- StrangerError      3   a file that is none of ours, where one of ours is wanted
     +-- StorageError       3   the disk refused to take what was written to it
     +-- ToolchainError     4   no Node, no tokenizer, a wrong hash, a worker that died
     +-- NetworkError       5   the tokenizer could not be fetched
     +-- SourceError        6   the tokenizer refused a PBASIC source: file, line, column, its words
     +-- RigError           7   a target that does not answer, or not as it should: BLOCKED
     |    +-- TargetTimeout     it gave no decision in time
     |    +-- IdentityError     it runs other programs than those to be tried
     +-- FlashError         8   a download that had begun and did not end well
     +-- MismatchError      9   a decision that is not the simulator's: FAIL
     +-- UnprovenError     11   not enough evidence for a verdict
     |    +-- LackingError      the program lacks what every generated program has
     +-- StoppedError      10   stopped by the user or a full disk; the run folder can be resumed

The numbers are the exit codes of the command line. 1 is a bug of ours, 2 is usage (click's).
A wrong argument to a function of the library is a `TypeError` or `ValueError`, not one of these.
"""

from typing import ClassVar


class CgagenError(Exception):
    """Anything a user can mend. `str(error)` is the sentence that they read."""

    exit_code: ClassVar[int] = 1


class RobotError(CgagenError):
    """A robot or arena file says something that cannot be: file, key, what is allowed."""

    exit_code = 3


class MeasurementError(CgagenError):
    """A table of measurements: file, line, column, and what is allowed there."""

    exit_code = 3


class GenomeError(CgagenError):
    """A genome of 191 characters, with a 2 in it, or made for another kind of robot."""

    exit_code = 3


class RunError(CgagenError):
    """A run folder that is half-written, from another version, or already in use."""

    exit_code = 3


class TemplateError(CgagenError):
    """A template that names an unknown word, cannot be parsed, or is missing."""

    exit_code = 3


class FolderError(CgagenError):
    """An output folder that holds something else; `--force` is the way past it."""

    exit_code = 3


class SamePlaceError(FolderError):
    """Two outputs of one call, or an output and an input, are one file: a matter of usage."""

    exit_code = 2


class ImageError(CgagenError):
    """Bytes that are not the image of a Stamp: wrong length, or no program in them."""

    exit_code = 3


class BudgetError(CgagenError):
    """A program that leaves less EEPROM or RAM free than the robot needs in reserve."""

    exit_code = 3


class BenchError(CgagenError):
    """A bench that cannot be: a file with an unknown part, a wire to nowhere."""

    exit_code = 3


class ContentionError(BenchError):
    """Two drivers hold one wire at different levels: a short circuit."""


class TraceError(CgagenError):
    """A trace that is malformed, cut, out of order or of another robot: file, line, what."""

    exit_code = 3


class ReadingError(CgagenError, ValueError):
    """A reading of other sensors than the robot's, or of counts that no chip has.

    It is a `ValueError`, too: a test of a user's that makes one up has called us wrongly.
    """

    exit_code = 3


class SymbolError(CgagenError):
    """A variable, pin, label or DATA that a program does not have; the nearest names."""

    exit_code = 3


class ExecutionError(CgagenError):
    """A program did what no document describes: a bad opcode, a broken address, its place."""

    exit_code = 3


class StrangerError(CgagenError):
    """A file that is none of ours; what it seems to be, and what is wanted."""

    exit_code = 3


class StorageError(CgagenError):
    """The disk is full, read-only or gone; nothing half-written is left behind."""

    exit_code = 3


class ToolchainError(CgagenError):
    """No Node, no tokenizer, a tokenizer with the wrong hash, or a worker that died."""

    exit_code = 4


class NetworkError(CgagenError):
    """The tokenizer could not be fetched."""

    exit_code = 5


class SourceError(CgagenError):
    """The tokenizer refused a PBASIC source.

    Attributes:
        code: the tokenizer's error number, 101 to 231; 0 where the refusal is our own.
        line: line of the source, from 1; None where the tokenizer names no position.
        column: column in that line, from 1; None likewise.
        length: characters that the error covers; 0 where unknown.
    """

    exit_code = 6

    def __init__(
        self,
        message: str,
        *,
        code: int = 0,
        line: int | None = None,
        column: int | None = None,
        length: int = 0,
    ) -> None:
        super().__init__(message)
        self.code = code
        self.line = line
        self.column = column
        self.length = length


class RigError(CgagenError):
    """A target, its port or its wiring is sick; nothing is known of the firmware: BLOCKED."""

    exit_code = 7


class TargetTimeout(RigError):  # noqa: N818  a word of the field
    """A target gave no decision in time, however often it was asked."""


class IdentityError(RigError):
    """A target runs other programs than those that are to be tried."""


class FlashError(CgagenError):
    """A download had begun and not every packet was taken: the chip holds half a program."""

    exit_code = 8


class MismatchError(CgagenError):
    """A target decides otherwise than the simulator: FAIL."""

    exit_code = 9


class UnprovenError(CgagenError):
    """There is not enough evidence for a verdict: UNPROVEN."""

    exit_code = 11


class LackingError(UnprovenError):
    """A program lacks what every generated program has, so it cannot be judged by it."""


class StoppedError(CgagenError):
    """The work was stopped before its end and can be resumed from what is on the disk."""

    exit_code = 10
