"""Quick ways through an instruction that takes time, against the plain one: `compile_after=None`.

Two chips on common wires: whoever pulses, sends or waits has somebody who answers in the middle.
"""

import random

import pytest

from cgagen.emulator.bench import Bench
from cgagen.emulator.chip import Chip
from cgagen.emulator.parts.probe import Probe
from cgagen.emulator.parts.servo import Servo
from cgagen.emulator.wires import Strength
from cgagen.errors import ContentionError
from cgagen.tokenizer import Tokenizer

SECOND_NS = 1_000_000_000

PULSES = """' {$STAMP BS2}
' {$PBASIC 2.5}
width VAR Byte
turn VAR Nib
OUTPUT 0
OUTPUT 1
OUTPUT 6
OUTPUT 7
DO
  FOR turn = 0 TO 5
    PULSOUT turn & 1, width * 4 + turn
    width = width + 77
    PULSOUT 2, 30
    INPUT 2
    PULSOUT 6, 200 + (turn / 2 * 180)           ' a servo alone: too short, or one that counts
    PULSOUT 7, 600
    IF turn = 2 THEN HIGH 6
    IF turn = 4 THEN LOW 6
    PULSOUT 6, 700
  NEXT
  PULSOUT 0, 0
  PAUSE 2
  PULSOUT 1, 500
LOOP
"""

ANSWERS = """' {$STAMP BS2p}
' {$PBASIC 2.5}
time VAR Word
edge VAR Bit
DO
  PULSIN 0, 1, time
  PULSOUT 3, time // 500
  SEROUT 4, 16624, [DEC time, CR, "abc"]
  RCTIME 1, 1, time
  edge = IN0 ^ IN1
  PULSOUT 5, 100 * edge + 20
  OUTPUT 5
LOOP
"""


def bench_of(tokenizer: Tokenizer, compile_after: int | None) -> tuple[Bench, list[Probe]]:
    """Return both chips on six wires with a probe on each, and two servos."""
    bench = Bench()
    for name, source in (("one", PULSES), ("two", ANSWERS)):
        image = tokenizer.compile(source).image
        bench.add_chip(Chip(name, [image], bench.clock, compile_after=compile_after))
    probes = []
    for pin in range(6):
        wire = bench.connect(f"wire{pin}", f"one.P{pin}", f"two.P{pin}", pull=pin & 1)
        probes.append(bench.add_part(Probe(f"probe{pin}", bench.clock, wire)))
    for pin in (6, 7):
        servo = Servo(f"servo{pin}", bench.clock, bench.connect(f"wire{pin}", f"one.P{pin}"))
        bench.add_part(servo)
    bench.wires["wire7"].drive("board", 0, Strength.RESISTOR)
    return bench, probes


def seen(bench: Bench, probes: list[Probe]) -> tuple[object, ...]:
    """Return all that can be told of both chips, and all edges."""
    states = [chip.snapshot() for chip in bench.chips.values()]
    plain = [
        state._replace(booking=state.booking and (state.booking[0], 0), polling=None)  # type: ignore[arg-type]
        for state in states
    ]
    parts = [part.state() for part in bench.parts.values()]
    levels = [wire.level for wire in bench.wires.values()]
    return bench.clock.now_ns, plain, levels, parts, [probe.edges for probe in probes]


def test_quick_or_plain_makes_no_difference(tokenizer: Tokenizer) -> None:
    """At every one of 150 moments, in pulses, between them, in a byte; some are resets."""
    runs = []
    for compile_after in (None, 0, 1):
        bench, probes = bench_of(tokenizer, compile_after)
        moments, run = random.Random(3), []
        for _ in range(150):
            bench.run(bench.clock.now_ns + moments.randrange(1, SECOND_NS // 200))
            run.append(seen(bench, probes))
            if moments.random() < 0.05:
                bench.reset("one", moments.randrange(SECOND_NS // 2000))
        runs.append(run)
    assert all(probe.count > 10 for probe in probes[:5])
    pulses = [servo.pulses for servo in bench.parts_of(Servo).values()]
    assert all(one.taken > 10 for one in pulses)
    assert pulses[0].odd > 10
    for one, two, three in zip(*runs, strict=True):
        assert one == two == three


def test_a_pulse_that_is_restored_goes_on(tokenizer: Tokenizer) -> None:
    bench, probes = bench_of(tokenizer, 0)
    moments = random.Random(4)
    bench.run(SECOND_NS // 4)
    for _ in range(12):
        bench.run(bench.clock.now_ns + moments.randrange(1, SECOND_NS // 300))
        before = bench.snapshot()
        end_ns = bench.clock.now_ns + SECOND_NS // 50
        bench.run(end_ns)
        first = seen(bench, probes)
        bench.restore(before)
        bench.run(end_ns)
        assert seen(bench, probes) == first


def test_a_short_circuit_in_a_pulse_is_found_at_its_edge(tokenizer: Tokenizer) -> None:
    """Quick or plain, the pin is left as it was when the other output was met."""
    source = "' {$STAMP BS2}\nOUTPUT 3\nagain: PULSOUT 3, 100\nGOTO again\n"
    found = []
    for compile_after in (None, 0):
        bench = Bench()
        image = tokenizer.compile(source).image
        chip = bench.add_chip(Chip("one", [image], bench.clock, compile_after=compile_after))
        wire = bench.connect("wire", "one.P3")
        bench.run(SECOND_NS // 100)
        while wire.level:
            bench.run(bench.clock.now_ns + 10_000)
        wire.drive("ground", 0)
        with pytest.raises(ContentionError, match=r"wire: one\.P3 drives 1, ground drives 0"):
            bench.run(SECOND_NS)
        found.append((bench.clock.now_ns, chip.pins.latch, wire.level, wire.drivers))
    assert found[0] == found[1]
