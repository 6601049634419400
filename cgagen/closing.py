"""What is opened and closed with a `with`."""

from abc import ABC, abstractmethod
from types import TracebackType
from typing import Self


class Closing(ABC):
    """Opened where a `with` begins, and closed behind it, whatever happens in between."""

    def open(self) -> None:  # noqa: B027  not everything has a beginning
        """Make it ready; by itself there is nothing to do."""

    @abstractmethod
    def close(self) -> None:
        """Let it go. Harmless when repeated."""

    def __enter__(self) -> Self:
        self.open()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()
