"""Sonars against their data sheets, and their faults."""

import pytest

from cgagen.emulator.clock import Clock
from cgagen.emulator.parts.ping import Ping
from cgagen.emulator.parts.probe import Probe
from cgagen.emulator.parts.sonar import middle_ns
from cgagen.emulator.parts.sonar_faults import LateEcho, NoEcho, StuckEcho
from cgagen.emulator.parts.srf04 import Srf04
from cgagen.emulator.wires import Wire
from cgagen.errors import ContentionError
from cgagen.tokenizer import Tokenizer
from tests.chip_programs import SECOND_NS, chip_of

US = 1_000
MS = 1_000_000


class PingBench:
    """A PING))) and a hand that triggers it."""

    def __init__(self) -> None:
        self.clock = Clock()
        self.wire = Wire("sig")
        self.ping = Ping("front", self.clock, self.wire)
        self.probe = Probe("probe", self.clock, self.wire)

    def trigger(self, width_ns: int = 5 * US) -> int:
        """Do what LOW, PULSOUT, PULSIN do; return when the trigger ended."""
        self.wire.drive("main.P4", 0)
        self.wire.drive("main.P4", 1)
        self.clock.run_until(self.clock.now_ns + width_ns)
        self.wire.drive("main.P4", 0)
        self.wire.drive("main.P4", None)
        return self.clock.now_ns

    def echo(self, width_ns: int = 5 * US) -> tuple[int, int] | None:
        """Trigger; return the echo's delay from the trigger's end, and its width."""
        ended_ns = self.trigger(width_ns)
        before = len(self.probe.pulses())
        self.clock.run_until(ended_ns + 30 * MS)
        pulses = self.probe.pulses()[before:]
        assert len(pulses) <= 1
        return (pulses[0].start_ns - ended_ns, pulses[0].width_ns) if pulses else None


@pytest.mark.parametrize(
    ("distance_in", "width_us"),
    [
        (10, 1474.92),  # 2 x 10 x 73.746
        (100, 14_749.2),
        (0.1, 115),  # the shortest that it gives
        (150, 20_000),  # the longest
        (None, 20_000),
    ],
)
def test_the_echo_is_as_long_as_the_sound_is_on_its_way(
    distance_in: float | None, width_us: float
) -> None:
    bench = PingBench()
    bench.ping.see(distance_in)
    assert bench.echo() == (750 * US, round(width_us * 1000))


def test_a_trigger_of_two_microseconds_is_enough_and_a_shorter_one_is_not() -> None:
    bench = PingBench()
    assert bench.echo(1_999) is None
    assert bench.echo(2_000) is not None
    assert (bench.ping.triggers, bench.ping.ignored) == (1, 1)


def test_an_echo_may_be_given_directly() -> None:
    bench = PingBench()
    bench.ping.see_echo(middle_ns(1843, 800))
    answer = bench.echo()
    assert answer is not None
    assert (answer[1] // 800, answer[1] % 800) == (1843, 400)


def test_triggers_while_it_is_busy_change_nothing() -> None:
    bench = PingBench()
    bench.ping.see(10)
    ended_ns = bench.trigger()
    bench.clock.run_until(ended_ns + 300 * US)
    bench.trigger()
    bench.clock.run_until(ended_ns + 30 * MS)
    echo = bench.probe.pulses()[-1]
    assert (echo.start_ns - ended_ns, echo.width_ns) == (750 * US, 1_474_920)
    assert (bench.ping.triggers, bench.ping.ignored) == (1, 1)


def test_it_wants_200_us_before_the_next_trigger() -> None:
    bench = PingBench()
    bench.ping.see_echo(115 * US)
    over_ns = bench.trigger() + 750 * US + 115 * US
    bench.clock.run_until(over_ns + 190 * US)
    bench.trigger()
    assert (bench.ping.triggers, bench.ping.ignored) == (1, 1)
    bench.clock.run_until(over_ns + 201 * US)
    bench.trigger()
    assert (bench.ping.triggers, bench.ping.ignored) == (2, 1)


def test_a_pin_that_still_drives_low_is_a_short_circuit() -> None:
    bench = PingBench()
    bench.trigger()
    bench.wire.drive("main.P4", 0)
    with pytest.raises(ContentionError, match=r"sig: front drives 1, main\.P4 drives 0"):
        bench.clock.run_until(10 * MS)


def test_sig_is_low_when_nobody_drives_it() -> None:
    assert PingBench().wire.level == 0


def test_without_an_echo_nothing_comes_and_the_fault_says_so() -> None:
    bench = PingBench()
    fault = NoEcho("dead", bench.clock, bench.ping, from_ns=50 * MS, until_ns=100 * MS)
    assert bench.echo() is not None
    assert (fault.fired, fault.first_ns) == (0, None)
    bench.clock.run_until(60 * MS)
    assert bench.echo() is None
    assert (fault.fired, fault.first_ns) == (1, 60 * MS + 5 * US)
    bench.clock.run_until(110 * MS)
    assert bench.echo() is not None
    assert fault.fired == 1


def test_a_late_echo_has_its_width() -> None:
    bench = PingBench()
    fault = LateEcho("late", bench.clock, bench.ping, 3 * MS)
    bench.ping.see(10)
    bench.clock.run_until(1)
    assert bench.echo() == (3 * MS + 750 * US, 1_474_920)
    assert fault.fired == 1


class SrfBench:
    """An SRF04 and a hand that triggers it."""

    def __init__(self, mode_grounded: bool = False) -> None:
        self.clock = Clock()
        self.trigger_wire, self.echo_wire = Wire("trigger"), Wire("echo")
        self.srf = Srf04("front", self.clock, self.trigger_wire, self.echo_wire, mode_grounded)
        self.probe = Probe("probe", self.clock, self.echo_wire)

    def trigger(self, width_ns: int = 10 * US) -> int:
        self.trigger_wire.drive("main.P4", 1)
        self.clock.run_until(self.clock.now_ns + width_ns)
        self.trigger_wire.drive("main.P4", 0)
        return self.clock.now_ns


@pytest.mark.parametrize(
    ("distance_in", "width_us"), [(10, 1474.92), (0.1, 174), (None, 36_000), (300, 36_000)]
)
def test_an_srf04_starts_with_the_falling_edge(distance_in: float | None, width_us: float) -> None:
    bench = SrfBench()
    bench.srf.see(distance_in)
    ended_ns = bench.trigger(500 * US)
    bench.clock.run_until(ended_ns + 50 * MS)
    (echo,) = bench.probe.pulses()
    # eight cycles of 40 kHz and 100 us of blanking
    assert (echo.start_ns - ended_ns, echo.width_ns) == (300 * US, round(width_us * 1000))


def test_an_srf04_wants_ten_microseconds_and_ten_milliseconds() -> None:
    bench = SrfBench()
    bench.srf.see_echo(1 * MS)
    bench.trigger(9_999)
    assert (bench.srf.triggers, bench.srf.ignored) == (0, 1)
    ended_ns = bench.trigger()
    bench.clock.run_until(ended_ns + 10 * MS)
    bench.trigger()
    assert (bench.srf.triggers, bench.srf.ignored) == (1, 2)
    bench.clock.run_until(ended_ns + 300 * US + 1 * MS + 10 * MS + 1)
    bench.trigger()
    assert bench.srf.triggers == 2


def test_a_grounded_mode_pin_puts_the_echo_off_by_300_us() -> None:
    """S8 p. 6; the range stays."""
    bench = SrfBench(mode_grounded=True)
    bench.srf.see(10)
    ended_ns = bench.trigger()
    bench.clock.run_until(ended_ns + 50 * MS)
    (echo,) = bench.probe.pulses()
    assert (echo.start_ns - ended_ns, echo.width_ns) == (600 * US, 1_474_920)


def test_a_stuck_sonar_hears_nothing_that_is_farther() -> None:
    """Three owners: 422 to 428 counts of 2 us for everything beyond 14 or 15 cm."""
    bench = PingBench()
    fault = StuckEcho("stuck", bench.clock, bench.ping, 850 * US, until_ns=100 * MS)
    for distance_in, width_ns in ((None, 850_000), (40, 850_000), (3, 442_476)):
        bench.ping.see(distance_in)
        assert bench.echo() == (750 * US, width_ns)
    assert fault.fired == 2
    bench.clock.run_until(100 * MS)
    bench.ping.see(None)
    assert bench.echo() == (750 * US, 20 * MS)


def test_a_silence_wanders_and_a_target_does_not() -> None:
    """S10 (119926): 9,991 to 10,005 counts of a BS2 within a day's warming."""
    bench = PingBench()
    bench.ping.hear_nothing(19_982 * US, 28 * US)
    widths = []
    for _ in range(9):
        answer = bench.echo()
        assert answer is not None
        widths.append(answer[1])
    assert widths == [*(19_982_000 + 4_000 * step for step in range(8)), 19_982_000]
    bench.ping.see(10)
    assert [bench.echo(), bench.echo()] == [(750 * US, 1_474_920)] * 2


def test_what_is_too_far_is_not_heard() -> None:
    """18.5 ms are 125.4 in (S6)."""
    bench = PingBench()
    for distance_in, width_ns in ((125.4, 18_495_497), (125.5, 20_000_000)):
        bench.ping.see(distance_in)
        assert bench.echo() == (750 * US, width_ns)


def test_two_faults_of_one_sonar_add_up() -> None:
    bench = PingBench()
    bench.ping.see(10)
    LateEcho("late", bench.clock, bench.ping, MS)
    NoEcho("dead", bench.clock, bench.ping, from_ns=100 * MS)
    later = LateEcho("later", bench.clock, bench.ping, 2 * MS)
    bench.clock.run_until(1)
    assert bench.echo() == (3 * MS + 750 * US, 1_474_920)
    bench.clock.run_until(200 * MS)
    assert bench.echo() is None
    assert later.fired == 1


@pytest.mark.parametrize(("model", "grounded", "seen"), [
    ("BS2", False, {0, 1, 2, 4, 8}),  # the shortest tokens
    ("BS2", True, set(range(15))),
    ("BS2p", False, set(range(15))),
])  # fmt: skip
def test_a_slow_chip_sees_an_srf04_on_low_pins_or_with_its_mode_pin_grounded(
    model: str, grounded: bool, seen: set[int], tokenizer: Tokenizer
) -> None:
    """S8 p. 6: a Stamp takes longer to look at higher pins, and misses the echo there."""
    found = set()
    for pin in range(15):
        source = f"w VAR Word\nLOW 15\nPULSOUT 15, 13\nPULSIN {pin}, 1, w\nSTOP"
        chip = chip_of(tokenizer, source, model=model)
        trigger, echo = chip.pins.wires[15], chip.pins.wires[pin]
        Srf04("srf", chip.clock, trigger, echo, mode_grounded=grounded).see(10)
        chip.run(SECOND_NS)
        assert chip.ended == "STOP"
        found |= {pin} if chip.registers["W0"] else set()
    assert found == seen
