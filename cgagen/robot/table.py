"""Tables of robot and arena files."""

from typing import ClassVar

from cgagen import tables
from cgagen.errors import CgagenError, RobotError

LAST_PIN = 15
"""Of a Stamp's sixteen."""


MOST_NAME = 200
"""Characters of a name. Choice: it stands in headings and rows, where no more can be read."""


class Table(tables.Table):
    """One table of such a file; it raises `RobotError`."""

    REFUSAL: ClassVar[type[CgagenError]] = RobotError

    def label(self, key: str) -> str:
        """Return a name that people give: any text that can be printed on one line."""
        return self.checked_label(key, self.text(key))

    def checked_label(self, key: str, text: str) -> str:
        """Return such a name that was read otherwise; `key` says where it stands."""
        bad = next((one for one in text if not one.isprintable()), None)
        if bad is not None:
            raise self.error(key, f"U+{ord(bad):04X} in it cannot be printed; leave it out")
        if not text.strip():
            raise self.error(key, "nothing but blanks; give it a name")
        if len(text) > MOST_NAME:
            raise self.error(key, f"{len(text)} characters; at most {MOST_NAME} are allowed")
        return text
