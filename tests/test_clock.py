"""The clock: order at equal times, and bookings that are taken back and put back."""

from cgagen.emulator.clock import Clock, Timer


def test_equal_times_go_in_the_order_booked() -> None:
    clock, seen = Clock(), ""

    def note(letter: str) -> None:
        nonlocal seen
        seen += letter

    for letter in "abc":
        clock.at(5, lambda letter=letter: note(letter))  # type: ignore[misc]
    clock.run_until(5)
    assert seen == "abc"


def test_a_booking_can_be_put_back_while_the_queue_still_holds_it() -> None:
    """As `Chip.restore` does at the moment of its snapshot."""
    clock, seen = Clock(), []
    timer = Timer(clock, lambda: seen.append(clock.now_ns))
    timer.at(10)
    state = timer.state()
    for _ in range(3):
        timer.restore(state)
    clock.run_until(20)
    assert seen == [10]
