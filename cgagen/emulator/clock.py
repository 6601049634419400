"""One clock for the whole bench: integer nanoseconds and a queue.

What happens at equal times happens in the order in which it was booked, so runs repeat exactly.
A queue of actions cannot be copied; whoever books keeps its booking in a `Timer`, which can.
"""

import heapq
from collections.abc import Callable

NEVER_NS = 1 << 62
"""Later than anything."""

Action = Callable[[], None]


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
        # An entry is void where its timer has been booked anew or cancelled since.
        self._queue: list[tuple[int, int, Timer]] = []
        self._order = 0

    def at(self, time_ns: int, action: Action) -> "Timer":
        """Book an action; what is returned can be cancelled.

        Raises:
            ValueError: the time is past.
        """
        timer = Timer(self, action)
        timer.at(time_ns)
        return timer

    def after(self, delay_ns: int, action: Action) -> "Timer":
        """Book an action for `delay_ns` from now. Zero means: later in this instant."""
        return self.at(self.now_ns + delay_ns, action)

    def bookings(self) -> list[tuple[int, int]]:
        """Return time and order of everything that is booked, the next first."""
        return sorted({(time, order) for time, order, timer in self._queue if timer.order == order})

    def state(self) -> tuple[int, int]:
        """Return what `restore` needs; bookings are the business of those who made them."""
        return self.now_ns, self._order

    def restore(self, state: tuple[int, int]) -> None:
        """Go back to a time with an empty queue; each owner then restores its timer."""
        for _, _, timer in self._queue:
            timer.order = 0
        self._queue.clear()
        self.now_ns, self._order = state
        self.limit_ns = self.now_ns

    def next_ns(self) -> int:
        """Return the time of the next booking, or `NEVER_NS`."""
        queue = self._queue
        while queue and queue[0][2].order != queue[0][1]:
            heapq.heappop(queue)
        return queue[0][0] if queue else NEVER_NS

    def run_next(self) -> bool:
        """Go to the next booking and carry it out; False where there is none."""
        if self.next_ns() == NEVER_NS:
            return False
        self.now_ns, _, timer = heapq.heappop(self._queue)
        timer.order = 0
        timer.action()
        return True

    def advance(self, time_ns: int) -> bool:
        """Go to a time at once, from inside an action, where nobody has anything before it.

        That spares whoever goes on at that time a booking. False, and nothing happens, where
        something is booked up to that time, where `run_until` does not go so far, or where it
        is to stop.
        """
        if time_ns > self.limit_ns or self.stopped:
            return False
        queue = self._queue
        while queue and queue[0][2].order != queue[0][1]:  # as `next_ns`, without a call
            heapq.heappop(queue)
        if queue and queue[0][0] <= time_ns:
            return False
        self.now_ns = time_ns
        return True

    def run_until(self, time_ns: int) -> None:
        """Carry out everything that is booked up to a time, that time included, and go there.

        Ends earlier, and says so in `stopped`, after an action that called `stop`.

        Raises:
            TypeError: the time is no whole number, as 1e9 is none.
        """
        if not hasattr(time_ns, "__index__"):
            raise TypeError(f"{time_ns} is no whole number of nanoseconds; write it as 1_000_000")
        self.stopped = False
        self.limit_ns = time_ns
        queue = self._queue
        try:
            while queue and queue[0][0] <= time_ns:
                now_ns, order, timer = heapq.heappop(queue)
                if timer.order == order:
                    timer.order = 0
                    self.now_ns = now_ns
                    timer.action()
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

    Attributes:
        action: see above.
        order: which of the bookings of the whole run it is; decides at equal times. 0: not booked.
        time_ns: when it comes, if it is booked.

    >>> clock, seen = Clock(), []
    >>> timer = Timer(clock, lambda: seen.append(clock.now_ns))
    >>> timer.after(30); before, booked = clock.state(), timer.state()
    >>> clock.run_until(100); clock.restore(before); timer.restore(booked)
    >>> clock.run_until(100); seen
    [30, 30]
    """

    __slots__ = ("_clock", "action", "order", "time_ns")

    def __init__(self, clock: Clock, action: Action) -> None:
        self._clock = clock
        self.action = action
        self.order = 0
        self.time_ns = 0

    def at(self, time_ns: int) -> None:
        """Book the action, in place of an earlier booking.

        Raises:
            ValueError: the time is past.
        """
        clock = self._clock
        if time_ns < clock.now_ns:
            raise ValueError(f"{time_ns} ns is past; it is {clock.now_ns} ns")
        clock._order = self.order = order = clock._order + 1
        self.time_ns = time_ns
        heapq.heappush(clock._queue, (time_ns, order, self))

    def after(self, delay_ns: int) -> None:
        """Book the action for `delay_ns` from now."""
        self.at(self._clock.now_ns + delay_ns)

    def cancel(self) -> None:
        """Take the booking back; harmless where there is none."""
        self.order = 0

    @property
    def due_ns(self) -> int | None:
        """When the action comes; None where it is not booked."""
        return self.time_ns if self.order else None

    def state(self) -> Booking | None:
        """Return the booking as a value; None where there is none."""
        return (self.time_ns, self.order) if self.order else None

    def restore(self, state: Booking | None) -> None:
        """Make the booking what it was; `Clock.restore` has been called before."""
        self.time_ns, self.order = state or (0, 0)
        if state is not None:
            heapq.heappush(self._clock._queue, (*state, self))

    def __lt__(self, other: "Timer") -> bool:
        """Order a timer and itself: the queue may still hold a booking that is put back."""
        return False
