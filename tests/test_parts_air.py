"""Sonars that hear one another: late echoes, on two parts and on the robots' own programs."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from itertools import pairwise
from pathlib import Path

import pytest

from cgagen.emulator.bench import Bench
from cgagen.emulator.bench_file import parse_bench
from cgagen.emulator.clock import Clock
from cgagen.emulator.parts.air import Air
from cgagen.emulator.parts.ping import Ping
from cgagen.emulator.parts.probe import Probe
from cgagen.emulator.parts.sonar import US_PER_IN, Sonar
from cgagen.emulator.parts.srf04 import Srf04
from cgagen.emulator.wires import Wire
from cgagen.errors import BenchError
from cgagen.tokenizer import Tokenizer
from hil.emulated import PinsTarget
from hil.subject import Subject, subject_of
from hil.target import Stimulus
from tests.firmware_cases import built

US = 1_000
MS = 1_000_000
OLD_REST = "  PAUSE 5 ' "
"""As the programs were: a rest behind the echo, and not from trigger to trigger."""


class Pair:
    """A PING))) and an SRF04 or a second PING))), in one air."""

    def __init__(self, other: str = "ping") -> None:
        self.clock = Clock()
        self.wires = {name: Wire(name) for name in ("one", "other", "echo")}
        self.one: Sonar = Ping("one", self.clock, self.wires["one"])
        self.other: Sonar = (
            Ping("other", self.clock, self.wires["other"])
            if other == "ping"
            else Srf04("other", self.clock, self.wires["other"], self.wires["echo"])
        )
        heard = self.wires["other" if other == "ping" else "echo"]
        self.probe = Probe("probe", self.clock, heard)
        self.air = Air("air", self.clock, (self.one, self.other))

    def trigger(self, name: str) -> None:
        """Trigger a sonar now."""
        self.wires[name].drive("chip", 1)
        self.clock.run_until(self.clock.now_ns + 12 * US)
        self.wires[name].drive("chip", 0)
        self.wires[name].drive("chip", None)

    def heard_us(self) -> list[float]:
        """Return the widths of the other's echoes in us."""
        return [one.width_ns / US for one in self.probe.pulses() if one.width_ns > 20 * US]


@pytest.mark.parametrize("other", ["ping", "srf04"])
def test_a_late_echo_of_one_sonar_ends_the_echo_of_another(other: str) -> None:
    """A wall at 60 in behind a target at 10 in: 8,850 us and 1,475 us behind the burst."""
    pair = Pair(other)
    pair.one.see(10)
    pair.air.see(60)
    pair.trigger("one")  # ended at 12 us: the burst leaves 750 us later
    pair.clock.run_until(7 * MS)
    pair.trigger("other")
    pair.clock.run_until(40 * MS)
    begins_us = 7_012 + (750 if other == "ping" else 300)
    assert pair.heard_us() == [pytest.approx(12 + 750 + 120 * US_PER_IN - begins_us)]
    assert pair.air.told() == {"strays": 1}


def test_ones_own_late_echo_is_no_stray_and_a_later_look_hears_it() -> None:
    pair = Pair()
    pair.other.see(90)
    pair.air.see(60, 120)
    pair.trigger("other")
    pair.clock.run_until(16 * MS)
    assert pair.heard_us() == [pytest.approx(180 * US_PER_IN)]
    pair.trigger("other")  # the wall at 120 in answers the first burst 17.7 ms behind it
    pair.clock.run_until(60 * MS)
    begun_us, again_us = 12 + 750, 16_012 + 750
    assert pair.heard_us()[1] == pytest.approx(begun_us + 240 * US_PER_IN - again_us)


def test_a_burst_while_another_listens_is_heard_too_and_nothing_below_the_shortest() -> None:
    pair = Pair()
    pair.air.see(0.5)
    pair.trigger("other")
    pair.clock.run_until(3 * MS)
    pair.trigger("one")
    pair.clock.run_until(40 * MS)
    assert pair.heard_us() == [pytest.approx(3_012 + 750 + US_PER_IN - (12 + 750))]
    pair.trigger("one")
    pair.clock.run_until(40 * MS + 30 * US)
    pair.trigger("other")
    pair.clock.run_until(90 * MS)
    assert pair.heard_us()[1] == 115


def test_without_walls_nobody_hears_another() -> None:
    pair = Pair()
    pair.one.see(10)
    pair.trigger("one")
    pair.clock.run_until(7 * MS)
    pair.trigger("other")
    pair.clock.run_until(60 * MS)
    assert pair.heard_us()[0] > 18_000
    assert pair.air.told() == {}


AIR = """
format = "cgagen-bench-1"
[wire.a]
ends = ["front.signal"]
[wire.b]
ends = ["left.signal"]
[part.front]
kind = "ping"
distance_in = 10
[part.left]
kind = "ping"
[part.air]
kind = "air"
sonars = ["front", "left"]
late_in = [60, 87.5]
"""


def bench_of(text: str) -> Bench:
    return parse_bench(text, "b.toml", Path())


def test_a_bench_file_has_an_air_and_a_snapshot_remembers_its_bursts() -> None:
    bench = bench_of(AIR)

    def trigger(name: str) -> None:
        wire = bench.wire(f"{name}.signal")
        wire.drive("hand", 1)
        bench.run(bench.clock.now_ns + 10 * US)
        wire.drive("hand", 0)
        wire.drive("hand", None)

    trigger("front")
    bench.run(7 * MS)
    before = bench.snapshot()
    seen: list[object] = []
    for _ in range(2):
        bench.restore(before)
        trigger("left")
        bench.run(60 * MS)
        seen.append(bench.part("air", Air).told())
    assert seen == [{"strays": 1}, {"strays": 1}]


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ('["front", "left"]', '["front", "lef"]', "'lef' is not a list of sonars"),
        ('["front", "left"]', '["front", "front"]', "'front' is not .* each once"),
        ('["front", "left"]', '"front"', "'front' is not a list"),
        ("[60, 87.5]", "[60, -1]", "-1 is not a number from 0 to 1000"),
        ("[60, 87.5]", "60", "60 is not a list of numbers"),
    ],
)
def test_an_air_that_cannot_be_is_refused(old: str, new: str, sentence: str) -> None:
    with pytest.raises(BenchError, match=sentence):
        bench_of(AIR.replace(old, new))
    twice = AIR + '[part.hall]\nkind = "air"\nsonars = ["left"]\n'
    with pytest.raises(BenchError, match="'left' shares another air; name"):
        bench_of(twice)


# -- The robots' own programs -----------------------------------------------------------------


@cache
def subject(case: str, rest: str = "") -> Subject:
    """A robot of ours; with a rest, another one between its sonars."""
    one = subject_of(built(case), case)
    if not rest:
        return one
    source = one.sources["main"]
    assert "  PAUSE EchoGap - (" in source
    image = Tokenizer().compile(source.replace("  PAUSE EchoGap - (", rest), "main.bsp").image
    return replace(one, images={**one.images, "main": image})


def counts(one: Subject, near_in: float, walls: Sequence[float]) -> list[list[int]]:
    """Return what each sonar counts, the first with a target and the others without, by wall."""
    robot, target = one.robot, PinsTarget(one)
    target.open()
    far = 20_000_000 // robot.main.pulsin_unit_ns
    near = robot.echo_count_of(near_in)
    lights = (0, 0) if robot.light else ()
    shown = Stimulus((near, *(far,) * (len(robot.sonars) - 1)), lights=lights)
    seen = []
    for wall in walls:
        target.present(shown)
        target.bench.part("air", Air).see(wall)
        assert target.look() is not None
        told = target.told()
        assert told is not None
        seen.append([*told.stimulus.sonars])
    return seen


@pytest.mark.parametrize("case", ["predator", "prey"])
def test_with_the_old_rest_a_wall_behind_a_near_target_is_an_obstacle_at_the_next_sonar(
    case: str,
) -> None:
    """A front target at 10 in and a wall at 55 to 85 in: the next sonar sees something near."""
    old = subject(case, OLD_REST)
    per_in = old.robot.echo_counts_per_in
    near = [row[1] / per_in for row in counts(old, 10, [55, 60, 70, 80, 85])]
    assert near == sorted(near)
    assert 1 < near[0] < 10
    assert 30 < near[-1] < 37


@pytest.mark.parametrize("case", ["predator", "prey", "predator-srf04", "prey-bs2"])
@pytest.mark.parametrize("near_in", [3, 10, 36, 100])
def test_no_wall_within_reach_is_heard_by_the_next_sonar(case: str, near_in: float) -> None:
    one = subject(case)
    rows = counts(one, near_in, [2, 20, 45, 52, 60, 70, 80, 87, 97, 110, 125, 135])
    assert {tuple(row) for row in rows} == {tuple(rows[0])}
    assert rows[0][0] == one.robot.echo_count_of(near_in)
    assert min(rows[0][1:]) == 20_000_000 // one.robot.main.pulsin_unit_ns


@pytest.mark.parametrize("near_in", [1, 20, 130])
@pytest.mark.parametrize("case", ["predator", "prey", "predator-free-running", "prey-free-silent"])
def test_from_trigger_to_trigger_it_is_the_gap_also_from_look_to_look(
    case: str, near_in: float
) -> None:
    one = subject(case)
    robot, target = one.robot, PinsTarget(one)
    target.open()
    bench, asked_ns = target.bench, []
    for sonar in robot.sonars:
        pin = sonar.pins[0]
        bench.chip("main").on_pin(
            pin, lambda level: asked_ns.append(bench.clock.now_ns) if level == 1 else None
        )
    lights = (1, 1) if robot.light else ()
    target.present(Stimulus((robot.echo_count_of(near_in),) * len(robot.sonars), lights=lights))
    end_ns = bench.clock.now_ns + 5_000 * MS
    while bench.clock.now_ns < end_ns:
        bench.run(end_ns)
    gaps = [later - before for before, later in pairwise(asked_ns)]
    gaps = [gap for gap in gaps if gap > MS]  # a PING)))'s echo is on the same pin
    assert len(gaps) > 2 * len(robot.sonars)
    assert min(gaps) >= robot.echo.trigger_gap_ms * MS
    assert min(gaps) < (robot.echo.trigger_gap_ms + 3) * MS
