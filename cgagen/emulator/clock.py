"""One clock for the whole bench: integer nanoseconds and a queue.

What happens at equal times happens in the order in which it was booked, so runs repeat exactly.
"""

import heapq
from collections.abc import Callable

NEVER_NS = 1 << 62
"""Later than anything."""

Action = Callable[[], None]


class Event:
    """Something booked. `cancel()` makes nothing of it; cancelling twice does no harm."""

    __slots__ = ("action", "time_ns")

    def __init__(self, time_ns: int, action: Action | None) -> None:
        self.time_ns = time_ns
        self.action = action

    def cancel(self) -> None:
        """Take the booking back."""
        self.action = None


class Clock:
    """The time of the bench, and what is booked on it.

    Attributes:
        now_ns: the time that everybody has reached.

    >>> clock, seen = Clock(), []
    >>> _ = clock.at(20, lambda: seen.append("b")); _ = clock.at(10, lambda: seen.append("a"))
    >>> clock.run_until(15); seen, clock.now_ns
    (['a'], 15)
    """

    __slots__ = ("_order", "_queue", "now_ns")

    def __init__(self) -> None:
        self.now_ns = 0
        self._queue: list[tuple[int, int, Event]] = []
        self._order = 0

    def at(self, time_ns: int, action: Action) -> Event:
        """Book an action.

        Raises:
            ValueError: the time is past.
        """
        if time_ns < self.now_ns:
            raise ValueError(f"{time_ns} ns is past; it is {self.now_ns} ns")
        event = Event(time_ns, action)
        self._order += 1
        heapq.heappush(self._queue, (time_ns, self._order, event))
        return event

    def after(self, delay_ns: int, action: Action) -> Event:
        """Book an action for `delay_ns` from now. Zero means: later in this instant."""
        return self.at(self.now_ns + delay_ns, action)

    def next_ns(self) -> int:
        """Return the time of the next booking, or `NEVER_NS`."""
        queue = self._queue
        while queue and queue[0][2].action is None:
            heapq.heappop(queue)
        return queue[0][0] if queue else NEVER_NS

    def run_next(self) -> bool:
        """Go to the next booking and carry it out; False where there is none."""
        if self.next_ns() == NEVER_NS:
            return False
        time_ns, _, event = heapq.heappop(self._queue)
        self.now_ns = time_ns
        action, event.action = event.action, None
        if action is not None:
            action()
        return True

    def run_until(self, time_ns: int) -> None:
        """Carry out everything that is booked up to a time, that time included, and go there."""
        while self.next_ns() <= time_ns:
            self.run_next()
        self.now_ns = max(self.now_ns, time_ns)
