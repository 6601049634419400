"""Durations of routines, from programs whose PAUSEs say how long they take."""

import pytest

from cgagen.emulator.chip import Chip
from cgagen.emulator.clock import Clock
from cgagen.emulator.durations import Duration, durations_text
from cgagen.emulator.programs import bench_of_image, bench_of_sources
from cgagen.emulator.timing import timing_of
from cgagen.errors import SymbolError
from cgagen.stamp.decode import decode
from cgagen.tokenizer import Tokenizer
from tests.chip_programs import SECOND_NS

HEAD = "' {$STAMP BS2}\n' {$PBASIC 2.5}\n"
MS = 1_000_000
SUB = "STOP\nsub:\nPAUSE n\nRETURN\n"


def measured(tokenizer: Tokenizer, body: str, *labels: str) -> dict[tuple[str, bool], Duration]:
    chip = Chip("chip", [tokenizer.compile(HEAD + body + "\n", "it.bs2")], Clock())
    found = chip.durations(*labels)
    chip.run(SECOND_NS)
    return {(row.label, row.called): row for row in found.rows()}


def test_a_called_routine_lasts_as_long_as_its_pauses(tokenizer: Tokenizer) -> None:
    """Its PAUSEs differ by 5, 10 and 30 ms; all else of it is the same each time."""
    body = "n VAR Byte\nFOR n = 5 TO 30 STEP 5\nIF n = 5 OR n = 10 OR n = 30 THEN GOSUB sub\nNEXT\n"
    rows = measured(tokenizer, body + SUB)
    row = rows["sub", True]
    rest_ns = row.best_ns - 5 * MS
    assert rows.keys() == {("sub", True)}
    assert row == Duration(
        "sub", 0, True, 3, 5 * MS + rest_ns, 15 * MS + rest_ns, 30 * MS + rest_ns
    )
    image = tokenizer.compile(HEAD + body + SUB).image
    timing = timing_of(image.model)
    pause, back = decode(image.eeprom, image.model, image.flags).instructions[-3:-1]
    slot_bits = 14
    bits = (pause.end - pause.address) + (back.end - back.address) + slot_bits
    assert (pause.name, back.name) == ("PAUSE", "RETURN")
    # PAUSE takes a while besides its bits and what it is told.
    # RETURN reads its slot of the header and then goes where that says: two jumps.
    known_ns = 2 * timing.fetch_ns + bits * timing.bit_ns + 2 * timing.jump_ns
    assert rest_ns == known_ns + timing.pause_setup_ns


def test_calls_inside_belong_to_the_caller(tokenizer: Tokenizer) -> None:
    body = (
        "GOSUB outer\nSTOP\nouter:\nPAUSE 10\nGOSUB inner\nGOSUB inner\nGOTO further\nSTOP\n"
        "further:\nPAUSE 3\nRETURN\ninner:\nPAUSE 20\nRETURN"
    )
    rows = measured(tokenizer, body)
    assert rows["inner", True].times == 2
    assert 20 * MS < rows["inner", True].best_ns == rows["inner", True].worst_ns < 21 * MS
    assert 53 * MS < rows["outer", True].worst_ns < 57 * MS
    assert 3 * MS < rows["further", False].worst_ns < 4 * MS
    assert rows["outer", True].times == rows["further", False].times == 1


def test_a_loop_is_measured_pass_by_pass(tokenizer: Tokenizer) -> None:
    body = (
        "n VAR Byte\nmain:\nn = n + 1\nGOSUB idle\nIF n < 5 THEN main\nlast:\nPAUSE 500\nSTOP\n"
        "idle:\nPAUSE n\nRETURN"
    )
    rows = measured(tokenizer, body)
    main, idle = rows["main", False], rows["idle", True]
    assert (main.times, idle.times) == (5, 5)
    assert idle.worst_ns - idle.best_ns == 4 * MS
    assert idle.mean_ns - idle.best_ns == 2 * MS
    assert main.best_ns > idle.best_ns
    assert ("last", False) not in rows  # it never ends


def test_a_routine_that_jumps_to_itself_is_one_call(tokenizer: Tokenizer) -> None:
    body = "n VAR Byte\nGOSUB again\nSTOP\nagain:\nPAUSE 10\nn = n + 1\nIF n < 3 THEN again\nRETURN"
    rows = measured(tokenizer, body)
    assert rows.keys() == {("again", True)}
    assert rows["again", True].times == 1
    assert 30 * MS < rows["again", True].worst_ns < 34 * MS


def test_on_gosub_is_a_call(tokenizer: Tokenizer) -> None:
    body = "n VAR Byte\nn = 1\nON n GOSUB a, b\nSTOP\na: PAUSE 1\nRETURN\nb: PAUSE 7\nRETURN"
    rows = measured(tokenizer, body)
    assert rows.keys() == {("b", True)}
    assert 7 * MS < rows["b", True].worst_ns < 8 * MS


def test_a_fifth_call_loses_the_first(tokenizer: Tokenizer) -> None:
    chain = "".join(f"r{n}:\nGOSUB r{n + 1}\nRETURN\n" for n in range(1, 5))
    body = f"n VAR Byte\nn = n + 1\nIF n = 2 THEN done\nGOSUB r1\n{chain}r5: RETURN\ndone: STOP"
    rows = measured(tokenizer, body)
    assert {label for label, called in rows if called} == {"r2", "r3", "r4", "r5"}


def test_only_the_labels_that_are_wanted(tokenizer: Tokenizer) -> None:
    body = "GOSUB a\nGOSUB b\nSTOP\na: RETURN\nb: RETURN"
    assert measured(tokenizer, body, " B").keys() == {("b", True)}
    with pytest.raises(SymbolError, match=r"it.bs2: no label c; there are a, b"):
        measured(tokenizer, body, "b", "c")
    image = tokenizer.compile(HEAD + body).image
    with pytest.raises(SymbolError, match="source in slot 0 is not known"):
        bench_of_image(image).chip("main").durations()


def test_labels_are_spelled_as_in_the_source(tokenizer: Tokenizer) -> None:
    body = "GOSUB turnleft\nGOSUB Idle\nSTOP\nTurnLeft: RETURN\nIdle: RETURN"
    assert measured(tokenizer, body, "TURNLEFT").keys() == {("TurnLeft", True)}
    with pytest.raises(SymbolError, match=r"no label zzz; there are TurnLeft, Idle"):
        measured(tokenizer, body, "zzz")
    with pytest.raises(SymbolError, match=r"no label idel; did you mean Idle\?"):
        measured(tokenizer, body, "idel")


def test_measuring_changes_nothing_and_ends(tokenizer: Tokenizer) -> None:
    compiled = tokenizer.compile(
        HEAD + "n VAR Word\nmain:\nn = n + 1\nGOSUB w\nGOTO main\nw: RETURN"
    )
    chips = [Chip("chip", [compiled], Clock()) for _ in range(2)]
    found = chips[0].durations()
    for chip in chips:
        chip.run(SECOND_NS)
    assert chips[0].snapshot() == chips[1].snapshot()
    rows = found.rows()
    found.end()
    for chip in chips:
        chip.run(2 * SECOND_NS)
    assert found.rows() == rows
    assert chips[0].snapshot() == chips[1].snapshot()


def test_a_reset_or_a_snapshot_ends_what_is_open(tokenizer: Tokenizer) -> None:
    compiled = tokenizer.compile(HEAD + "GOSUB sub\nSTOP\nsub:\nPAUSE 100\nRETURN")
    bench = bench_of_sources({0: compiled})
    chip = bench.chip("main")
    found = chip.durations()
    bench.run(50 * MS)
    state = bench.snapshot()
    chip.reset()
    bench.run(SECOND_NS)
    (row,) = found.rows()
    assert (row.times, row.worst_ns // MS) == (1, 100)
    bench.restore(state)
    bench.run(SECOND_NS)
    assert found.rows() == (row,)


def test_every_slot_has_routines(tokenizer: Tokenizer) -> None:
    head = "' {$STAMP BS2p}\n' {$PBASIC 2.5}\n"
    first = tokenizer.compile(head + "GOSUB sub\nRUN 1\nsub: PAUSE 5\nRETURN\n")
    other = tokenizer.compile(head + "GOSUB sub\nSTOP\nsub: PAUSE 9\nRETURN\n")
    bench = bench_of_sources({0: first, 1: other})
    found = bench.chip("main").durations("sub")
    bench.run(SECOND_NS)
    assert [(row.slot, row.times, row.best_ns // MS) for row in found.rows()] == [
        (0, 1, 5),
        (1, 1, 9),
    ]
    assert durations_text(found.rows()).count("\n") == 2
