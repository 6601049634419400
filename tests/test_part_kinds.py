"""Parts of a bench file: that every setting arrives where it belongs."""

from pathlib import Path

import pytest

from cgagen.emulator.bench import Bench
from cgagen.emulator.bench_file import parse_bench
from cgagen.emulator.parts.fault import Fault
from cgagen.emulator.parts.photocell import Photocell
from cgagen.emulator.parts.probe import Probe
from cgagen.emulator.parts.servo import Servo
from cgagen.emulator.parts.signal import Signal
from cgagen.emulator.parts.uart import Uart
from cgagen.emulator.parts.whisker import Whisker
from cgagen.errors import ContentionError

MS = 1_000_000


def bench_of(text: str) -> Bench:
    return parse_bench('format = "cgagen-bench-1"\n' + text, "b", Path())


SERIAL = """
[wire.line]
ends = ["a.transmit", "b.receive", "c.receive"]
[wire.back]
ends = ["a.receive"]
[part.a]
kind = "uart"
baud = 1200
seven_even = true
echo = true
send = "Az"
[part.b]
kind = "uart"
baud = 1200
seven_even = true
[part.c]
kind = "uart"
baud = 1200
"""


def test_a_uart_has_its_baud_rate_parity_and_echo() -> None:
    """Twenty bits at 1,200 baud are 16.7 ms; z has five ones, so its parity is 1."""
    bench = bench_of(SERIAL)
    bench.run(15 * MS)
    assert bench.part("b", Uart).received == b"A"
    bench.run(17 * MS)
    assert bench.part("b", Uart).received == b"Az"
    assert bench.part("c", Uart).received == b"A\xfa"
    assert bench.part("a", Uart).received == b"Az", "its own echo"


def test_a_uart_speaks_when_the_chip_listens() -> None:
    bench = bench_of(SERIAL.replace('"Az"', '"Az"\nsend_ms = 30'))
    bench.run(30 * MS - 1)
    assert bench.wires["line"].level == 1
    bench.run(47 * MS)
    assert bench.part("b", Uart).received == b"Az"


def test_an_inverted_uart_rests_low() -> None:
    bench = bench_of(SERIAL.replace('"Az"', '"Az"\ninverted = true'))
    assert bench.wires["line"].level == 0
    assert bench_of(SERIAL.replace('send = "Az"', "")).wires["line"].level == 1


@pytest.mark.parametrize(("mirrored", "angle_deg"), [("false", 20.0), ("true", -20.0)])
def test_a_servo_has_its_width_speed_and_direction(mirrored: str, angle_deg: float) -> None:
    bench = bench_of(
        '[wire.s]\nends = ["servo.signal", "pulse.output"]\n[part.servo]\nkind = "servo"\n'
        f"centre_us = 1400\nus_per_deg = 5\ndeg_per_s = 1000\nmirrored = {mirrored}\n"
        '[part.pulse]\nkind = "signal"\nlevel = 0\nchanges = [[1, 1], [2.5, 0]]\n'
    )
    servo = bench.part("servo", Servo)
    bench.run(round(12.5 * MS))
    assert servo.angle_deg == pytest.approx(angle_deg / 2)
    bench.run(40 * MS)
    assert servo.angle_deg == pytest.approx(angle_deg)


def test_a_photocell_has_its_light() -> None:
    bench = bench_of(
        '[wire.l]\nends = ["cell.signal"]\n[part.cell]\nkind = "photocell"\n'
        "capacitor_uf = 0.01\nresistance_ohm = 10_000\n"
    )
    assert bench.part("cell", Photocell).drain_ns == 127_296
    dark = '[wire.l]\nends = ["c.signal"]\n[part.c]\nkind = "photocell"\ncapacitor_uf = 1\n'
    assert bench_of(dark).part("c", Photocell).drain_ns is None


def test_a_whisker_may_be_touched_and_a_signal_may_be_weak() -> None:
    text = (
        '[wire.w]\nends = ["w.signal", "s.output"]\n[part.w]\nkind = "whisker"\ntouched = true\n'
        '[part.s]\nkind = "signal"\nlevel = 1\nresistor = true\n'
    )
    bench = bench_of(text)
    assert bench.part("w", Whisker).touched
    bench.wires["w"].drive("x", 0)
    assert bench.wires["w"].level == 0
    strong = bench_of(text.replace("resistor = true", ""))
    assert isinstance(strong.part("s", Signal), Signal)
    with pytest.raises(ContentionError, match="x drives 0, s drives 1"):
        strong.wires["w"].drive("x", 0)


def test_noise_has_its_seed() -> None:
    times = []
    for seed in (0, 0, 1):
        bench = bench_of(
            '[wire.w]\nends = ["p.signal"]\npull = "up"\n[part.p]\nkind = "probe"\n[fault.n]\n'
            f'kind = "noise"\nend = "p.signal"\nevery_us = 100\nwidth_us = 5\nseed = {seed}\n'
        )
        bench.run(MS)
        times.append(bench.part("n", Fault).first_ns)
    assert times[0] == times[1] != times[2]


def test_sonars_have_their_silence_their_mode_and_their_fault() -> None:
    bench = bench_of(
        '[part.ping]\nkind = "ping"\nsilence_us = 5000\ndrift_us = 700\n'
        '[part.near]\nkind = "ping"\n[part.srf]\nkind = "srf04"\n'
        "mode_grounded = true\necho_us = 900\n"
        '[part.hand]\nkind = "signal"\nlevel = 0\nchanges = [[1, 1], [1.02, 0]]\n'
        '[part.hand2]\nkind = "signal"\nlevel = 0\nchanges = [[1, 1], [1.02, 0], [1.03, -1]]\n'
        '[part.hand3]\nkind = "signal"\nlevel = 0\nchanges = [[1, 1], [1.02, 0], [1.03, -1]]\n'
        '[part.p1]\nkind = "probe"\n[part.p2]\nkind = "probe"\n[part.p3]\nkind = "probe"\n'
        '[wire.a]\nends = ["hand.output", "srf.trigger"]\n'
        '[wire.b]\nends = ["srf.echo", "p1.signal"]\n'
        '[wire.c]\nends = ["ping.signal", "hand2.output", "p2.signal"]\n'
        '[wire.d]\nends = ["near.signal", "hand3.output", "p3.signal"]\n'
        '[fault.f]\nkind = "stuck_echo"\npart = "near"\n'
    )
    bench.run(40 * MS)
    echoes = [bench.part(name, Probe).pulses()[-1] for name in ("p1", "p2", "p3")]
    assert [(one.start_ns, one.width_ns) for one in echoes] == [
        (1_620_000, 900_000),
        (1_770_000, 5_000_000),
        (1_770_000, 850_000),
    ]
