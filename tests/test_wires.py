"""Wires: what level comes of drivers, resistors, joints and faults."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cgagen.emulator.clock import Clock, Timer
from cgagen.emulator.pins import Pins
from cgagen.emulator.wires import Strength, Wire
from cgagen.errors import ContentionError


def test_an_output_wins_over_a_resistor_and_that_over_a_pull() -> None:
    wire = Wire("w", pull=1)
    wire.drive("switch", 0, Strength.RESISTOR)
    assert wire.level == 0
    wire.drive("main.P3", 1)
    assert (wire.level, wire.output) == (1, 1)
    wire.drive("main.P3", None)
    assert (wire.level, wire.output) == (0, None)
    wire.drive("switch", None)
    assert wire.level == 1


def test_equal_resistors_against_each_other_read_one() -> None:
    """Half of 5 V is above the threshold of 1.4 V."""
    wire = Wire("w")
    wire.drive("a", 0, Strength.RESISTOR)
    wire.drive("b", 1, Strength.RESISTOR)
    assert wire.level == 1


def test_contention_names_both_and_changes_nothing() -> None:
    wire = Wire("step")
    wire.drive("legs.P15", 0)
    with pytest.raises(ContentionError, match=r"step: main\.P3 drives 1, legs\.P15 drives 0"):
        wire.drive("main.P3", 1)
    assert (wire.level, wire.drivers) == (0, ("legs.P15",))


def test_a_driver_may_change_its_own_mind() -> None:
    wire = Wire("w")
    wire.drive("a", 0)
    wire.drive("a", 1)
    assert wire.level == 1


def test_contention_reaches_over_joints() -> None:
    wire = Wire("step")
    main, legs = Pins("main"), Pins("legs")
    wire.join(main.wires[3])
    wire.join(legs.wires[15])
    main.set_directions(1 << 3)
    legs.set_latch(1 << 15)
    with pytest.raises(ContentionError, match=r"step: legs\.P15 drives 1, main\.P3 drives 0"):
        legs.set_directions(1 << 15)


def test_joining_outputs_that_disagree_is_contention() -> None:
    one, other = Wire("one"), Wire("other")
    one.drive("a", 1)
    other.drive("b", 0)
    with pytest.raises(ContentionError, match="one: a drives 1, b drives 0"):
        one.join(other)


def test_an_end_that_leaves_keeps_its_own_drivers() -> None:
    wire, end = Wire("w", pull=1), Wire("main.P3")
    wire.join(end)
    end.drive("main.P3", 0)
    assert wire.level == 0
    end.cut("open")
    assert (wire.level, end.level) == (1, 0)
    end.mend("open")
    assert (wire.level, end.level) == (0, 0)


def test_a_joint_carries_the_pull_to_every_end() -> None:
    wire, end = Wire("w", pull=1), Wire("main.P3")
    assert end.level is None
    wire.join(end)
    assert end.level == 1


def test_all_ends_have_the_level_before_anybody_hears_of_it() -> None:
    wire, end = Wire("w"), Wire("e")
    wire.join(end)
    heard = []
    wire.listen(lambda level: heard.append((level, wire.level, end.level)))
    end.drive("x", 1)
    assert heard == [(1, 1, 1)]


def test_after_a_listener_has_answered_the_rest_hear_the_newest_level() -> None:
    wire, heard = Wire("w"), []

    def answer(level: int | None) -> None:
        if level == 1:
            wire.drive("a", 0)

    wire.listen(answer)
    wire.listen(heard.append)
    wire.drive("a", 1)
    assert heard == [0]


def test_a_whole_pulse_is_for_those_alone_who_need_no_edges() -> None:
    wire, end, pulses = Wire("w", pull=0), Wire("e"), list[int]()
    wire.join(end)
    assert wire.takers("a") is None, "nobody drives it"
    wire.drive("a", 0)
    assert wire.takers("a") == ()
    stop = end.listen(lambda level: None, pulses.append)
    assert wire.takers("a") == (pulses.append,)
    wire.listen(lambda level: None)()
    hears_edges = wire.listen(lambda level: None)
    assert wire.takers("a") is None
    hears_edges()
    end.drive("b", 0, Strength.RESISTOR)
    assert wire.takers("a") == (pulses.append,)
    assert wire.takers("b") is None, "no output"
    end.drive("b", 0)
    assert wire.takers("a") is None, "a pulse would be a short circuit"
    end.drive("b", None)
    wire.drive("a", 1)
    assert wire.takers("a") is None, "it is high already"
    wire.drive("a", 0)
    stop()
    assert wire.takers("a") == ()
    end.force("noise", 0)
    assert wire.takers("a") is None, "its level does not follow"
    end.force("noise", None)
    wire.watch(lambda: None)
    assert wire.takers("a") is None, "somebody watches"


def test_forcing_one_end_leaves_the_others_alone() -> None:
    wire, end = Wire("w", pull=1), Wire("e")
    wire.join(end)
    end.force("noise", 0)
    assert (wire.level, end.level, end.undisturbed) == (1, 0, 1)
    end.force("noise", None)
    assert end.level == 1


Drive = tuple[int, str, int | None, Strength]


@given(
    st.lists(
        st.tuples(
            st.integers(0, 2),
            st.sampled_from("abc"),
            st.sampled_from([0, 1, None]),
            st.sampled_from(Strength),
        ),
        max_size=20,
    ),
    st.sampled_from([0, 1, None]),
)
def test_the_level_is_the_firmest_opinion(drives: list[Drive], pull: int | None) -> None:
    """Against a model: a list of opinions, in the words of the class's promise."""
    ends = [Wire("w", pull), Wire("x"), Wire("y")]
    ends[0].join(ends[1])
    ends[1].join(ends[2])
    held: dict[str, tuple[int, Strength]] = {}
    for end, who, level, strength in drives:
        name = f"{who}{end}"
        others = {one for key, one in held.items() if key != name}
        if strength is Strength.OUTPUT and level is not None:
            if any(one == (1 - level, Strength.OUTPUT) for one in others):
                with pytest.raises(ContentionError):
                    ends[end].drive(name, level, strength)
                continue
        ends[end].drive(name, level, strength)
        held.pop(name, None)
        if level is not None:
            held[name] = (level, strength)
        opinions = list(held.values()) + ([] if pull is None else [(pull, Strength.PULL)])
        firmest = max((strength for _, strength in opinions), default=None)
        levels = [level for level, strength in opinions if strength == firmest]
        assert {one.level for one in ends} == {max(levels) if levels else None}


def test_the_state_of_a_wire_comes_back_in_silence() -> None:
    wire, end, heard = Wire("w", pull=1), Wire("e"), []
    wire.join(end)
    end.drive("a", 0)
    states = [(one, one.state()) for one in (wire, end)]
    end.cut("open")
    end.drive("a", None)
    end.force("noise", 1)
    wire.listen(heard.append)
    for one, state in states:
        one.restore(state)
    assert (wire.level, end.level, wire.ends, heard) == (0, 0, (wire, end), [])
    end.drive("a", None)
    assert (wire.level, heard) == (1, [1])


def test_bookings_at_one_time_keep_their_order_after_a_restore() -> None:
    clock, seen = Clock(), []
    first, second = Timer(clock, lambda: seen.append(1)), Timer(clock, lambda: seen.append(2))
    second.at(10)
    first.at(10)
    state, bookings = clock.state(), (first.state(), second.state())
    clock.run_until(20)
    clock.restore(state)
    first.restore(bookings[0])
    second.restore(bookings[1])
    assert clock.bookings() == [(10, 1), (10, 2)]
    clock.run_until(20)
    assert seen == [2, 1, 2, 1]


def test_a_restored_clock_forgets_what_was_booked_since() -> None:
    clock, seen = Clock(), []
    state = clock.state()
    timer = Timer(clock, lambda: seen.append(clock.now_ns))
    timer.at(5)
    clock.restore(state)
    assert timer.due_ns is None
    clock.run_until(10)
    assert seen == []
