"""Robot files as tables, and changes to them."""

from collections.abc import Callable
from typing import Any

from tests.pursuit import content

Content = dict[str, Any]


Change = Callable[[Content], object]


PREDATOR, PREY = content("servobot-predator"), content("servobot-prey")


def put(*path: str | int, to: Any) -> Change:
    """Return a change of one value, by its path."""

    def change(data: Content) -> None:
        at: Any = data
        for key in path[:-1]:
            at = at[key]
        at[path[-1]] = to

    return change
