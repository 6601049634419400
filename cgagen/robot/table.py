"""Tables of robot and arena files."""

from typing import ClassVar

from cgagen import tables
from cgagen.errors import CgagenError, RobotError

LAST_PIN = 15
"""Of a Stamp's sixteen."""


class Table(tables.Table):
    """One table of such a file; it raises `RobotError`."""

    REFUSAL: ClassVar[type[CgagenError]] = RobotError
