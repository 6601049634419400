"""A sonar that answers with what it is told, not with a distance."""

from cgagen.emulator.parts.sonar import Answer


class Forced:
    """Makes a sonar answer with just the count that is wanted, or not at all.

    Attributes:
        width_ns: of the echo; None for no echo.
    """

    def __init__(self) -> None:
        self.width_ns: int | None = None

    def spoil(self, answer: Answer) -> Answer | None:
        """Return the wanted answer."""
        return None if self.width_ns is None else answer._replace(width_ns=self.width_ns)
