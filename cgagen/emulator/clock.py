"""One clock for the whole bench: integer nanoseconds and a queue.

What happens at equal times happens in the order in which it was booked, so runs repeat exactly.
A queue of actions cannot be copied; whoever books keeps its booking in a `Timer`, which can.
"""

import heapq
from collections.abc import Callable

NEVER_NS = 1 << 62
"""Later than anything."""

Action = Callable[[], None]


class Event:
    """Something booked. `cancel()` makes nothing of it; cancelling twice does no harm.

    Attributes:
        time_ns: when.
        order: which of the bookings of the whole run it was; decides at equal times.
        action: what; None when it was cancelled or is done.
    """

    __slots__ = ("action", "order", "time_ns")

    def __init__(self, time_ns: int, order: int, action: Action | None) -> None:
        self.time_ns = time_ns
        self.order = order
        self.action = action

    def cancel(self) -> None:
        """Take the booking back."""
        self.action = None

    def __lt__(self, other: "Event") -> bool:
        """Order an event and its own earlier, cancelled self, which the queue may still hold."""
        return False


class Clock:
    """The time of the bench, and what is booked on it.

    Attributes:
        now_ns: the time that everybody has reached.
        limit_ns: how far `run_until` goes; the present while it does not run.
        stopped: somebody wants `run_until` to end where it is.

    >>> clock, seen = Clock(), []
    >>> _ = clock.at(20, lambda: seen.append("b")); _ = clock.at(10, lambda: seen.append("a"))
    >>> clock.run_until(15); seen, clock.now_ns
    (['a'], 15)
    """

    __slots__ = ("_order", "_queue", "limit_ns", "now_ns", "stopped")

    def __init__(self) -> None:
        self.now_ns = 0
        self.stopped = False
        self.limit_ns = 0
        self._queue: list[tuple[int, int, Event]] = []
        self._order = 0

    def at(self, time_ns: int, action: Action) -> Event:
        """Book an action.

        Raises:
            ValueError: the time is past.
        """
        if time_ns < self.now_ns:
            raise ValueError(f"{time_ns} ns is past; it is {self.now_ns} ns")
        self._order += 1
        return self.rebook(time_ns, self._order, action)

    def after(self, delay_ns: int, action: Action) -> Event:
        """Book an action for `delay_ns` from now. Zero means: later in this instant."""
        return self.at(self.now_ns + delay_ns, action)

    def rebook(self, time_ns: int, order: int, action: Action) -> Event:
        """Book an action again at the place that it had in a state that was restored."""
        event = Event(time_ns, order, action)
        heapq.heappush(self._queue, (time_ns, order, event))
        return event

    def bookings(self) -> list[tuple[int, int]]:
        """Return time and order of everything that is booked, the next first."""
        return sorted((time, order) for time, order, event in self._queue if event.action)

    def state(self) -> tuple[int, int]:
        """Return what `restore` needs; bookings are the business of those who made them."""
        return self.now_ns, self._order

    def restore(self, state: tuple[int, int]) -> None:
        """Go back to a time with an empty queue; each owner then calls `rebook`."""
        for _, _, event in self._queue:
            event.action = None
        self._queue.clear()
        self.now_ns, self._order = state
        self.limit_ns = self.now_ns

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

    def idle(self, span_ns: int) -> bool:
        """Return whether `advance` could go so far now."""
        return self.now_ns + span_ns <= self.limit_ns and self.next_ns() > self.now_ns + span_ns

    def advance(self, time_ns: int) -> bool:
        """Go to a time at once, from inside an action, where nobody has anything before it.

        That spares whoever goes on at that time a booking. False, and nothing happens, where
        something is booked up to that time, where `run_until` does not go so far, or where it
        is to stop.
        """
        if time_ns > self.limit_ns or self.stopped:
            return False
        queue = self._queue
        while queue and queue[0][2].action is None:  # as in `next_ns`: this is asked most of all
            heapq.heappop(queue)
        if queue and queue[0][0] <= time_ns:
            return False
        self.now_ns = time_ns
        return True

    def run_until(self, time_ns: int) -> None:
        """Carry out everything that is booked up to a time, that time included, and go there.

        Ends earlier, and says so in `stopped`, after an action that called `stop`.
        """
        self.stopped = False
        self.limit_ns = time_ns
        queue = self._queue
        try:
            while queue and queue[0][0] <= time_ns:
                now_ns, _, event = heapq.heappop(queue)
                action, event.action = event.action, None
                if action is not None:
                    self.now_ns = now_ns
                    action()
                    if self.stopped:
                        return
        finally:
            self.limit_ns = self.now_ns
        self.now_ns = max(self.now_ns, time_ns)

    def stop(self) -> None:
        """Let `run_until` end after the action under way."""
        self.stopped = True


Booking = tuple[int, int]
"""Time and order of an event."""


class Timer:
    """One action that is booked at most once at a time, and whose booking can be remembered.

    >>> clock, seen = Clock(), []
    >>> timer = Timer(clock, lambda: seen.append(clock.now_ns))
    >>> timer.after(30); before, booked = clock.state(), timer.state()
    >>> clock.run_until(100); clock.restore(before); timer.restore(booked)
    >>> clock.run_until(100); seen
    [30, 30]
    """

    __slots__ = ("_action", "_clock", "_event")

    def __init__(self, clock: Clock, action: Action) -> None:
        self._clock = clock
        self._action = action
        self._event: Event | None = None

    def at(self, time_ns: int) -> None:
        """Book the action, in place of an earlier booking.

        Raises:
            ValueError: the time is past.
        """
        self.cancel()
        self._event = self._clock.at(time_ns, self._action)

    def after(self, delay_ns: int) -> None:
        """Book the action for `delay_ns` from now."""
        self.at(self._clock.now_ns + delay_ns)

    def cancel(self) -> None:
        """Take the booking back; harmless where there is none."""
        if self._event is not None:
            self._event.cancel()
            self._event = None

    @property
    def booked(self) -> bool:
        """Whether the action is to come."""
        event = self._event
        return event is not None and event.action is not None

    @property
    def due_ns(self) -> int | None:
        """When the action comes; None where it is not booked."""
        state = self.state()
        return None if state is None else state[0]

    def state(self) -> Booking | None:
        """Return the booking as a value; None where there is none."""
        event = self._event
        return None if event is None or event.action is None else (event.time_ns, event.order)

    def restore(self, state: Booking | None) -> None:
        """Make the booking what it was; `Clock.restore` has been called before."""
        self.cancel()
        self._event = None if state is None else self._clock.rebook(*state, self._action)
