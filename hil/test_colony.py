"""Four Stamps with their real images hunt as the simulator says, step by step, to the capture."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from cgagen.build.bench import bench_text
from cgagen.emulator.parts.air import Air
from cgagen.emulator.parts.probe import Probe
from cgagen.emulator.parts.servo import Servo
from cgagen.genome import Genome
from cgagen.robot import load_arena
from cgagen.tokenizer import Tokenizer
from hil.colony import Colony
from hil.colony_bench import share_air
from hil.hunt import Hunt, episode_of, fixed_starts, hunt
from hil.subject import Subject, read_subject
from sim.numbers import WorldNumbers, world_numbers
from sim.starts import start_of

pytestmark = pytest.mark.hil_req("HUNT")

FIRMWARE = Path(__file__).parents[1] / "firmware"
STEPS = 200
SAMPLE = (16, 56, 77)
"""Fixed starts of the default run: a capture within 10 to 16 steps each, so that it is quick."""


@pytest.fixture(scope="module")
def tokenizer() -> Iterator[Tokenizer]:
    with Tokenizer() as shared:
        yield shared


@pytest.fixture(scope="module")
def predator() -> Subject:
    return read_subject(FIRMWARE / "predator")


@pytest.fixture(scope="module")
def prey() -> Subject:
    return read_subject(FIRMWARE / "prey")


@pytest.fixture(scope="module")
def numbers(predator: Subject, prey: Subject) -> WorldNumbers:
    return world_numbers(predator.robot, prey.robot, load_arena("colony"))


@pytest.fixture(scope="module")
def starts(predator: Subject, prey: Subject, numbers: WorldNumbers) -> NDArray[np.float64]:
    gap_units = load_arena("colony").start_gap_units
    return fixed_starts(predator, prey, numbers, gap_units, 100)


@pytest.fixture(scope="module")
def figure_7(numbers: WorldNumbers) -> NDArray[np.float64]:
    radii = numbers.predator.radius, numbers.prey.radius
    return start_of((268.75, 31.25, 180), (15, 150, 90), numbers.side, radii)


def agrees(result: Hunt) -> None:
    assert result.difference is None, result.difference.text()
    assert result.captured_at == result.episode.captured_at == len(result.steps)


def test_the_hunt_of_figure_7_is_the_simulators_up_to_the_capture(
    predator: Subject, prey: Subject, numbers: WorldNumbers, figure_7: NDArray[np.float64]
) -> None:
    result = hunt(predator, prey, numbers, figure_7, STEPS)
    agrees(result)
    assert result.captured_at == 54
    # What is compared is there: readings, states and movements of both, at every step.
    assert all(one.predator.said and one.prey.said for one in result.steps)
    assert len({one.predator.command for one in result.steps}) >= 4


@pytest.mark.parametrize("number", SAMPLE)
def test_a_fixed_start(
    number: int,
    predator: Subject,
    prey: Subject,
    numbers: WorldNumbers,
    starts: NDArray[np.float64],
) -> None:
    agrees(hunt(predator, prey, numbers, starts[number : number + 1], STEPS))


@pytest.mark.hil_slow
@pytest.mark.slow
def test_every_fixed_start(
    predator: Subject,
    prey: Subject,
    numbers: WorldNumbers,
    starts: NDArray[np.float64],
) -> None:
    """The hundred starts that evolution judges its best by: some minutes; `make hil-colony`."""
    results = [hunt(predator, prey, numbers, start[None, :], STEPS) for start in starts]
    differences = [
        f"start {number}: {one.difference.text()}"
        for number, one in enumerate(results)
        if one.difference is not None
    ]
    assert differences == []
    assert [one.captured_at for one in results] == [one.episode.captured_at for one in results]


def test_robots_that_hear_each_others_sonars_see_what_is_not_there(
    predator: Subject, prey: Subject, numbers: WorldNumbers, figure_7: NDArray[np.float64]
) -> None:
    """Both look at one instant: each robot's own gaps do not keep the other one's bursts away."""
    alone, together = (Colony(predator, prey, numbers, figure_7) for _ in range(2))
    room = share_air(together.bench)
    right, wrong = alone.step(), together.step()
    assert right is not None
    assert wrong is not None
    assert all(one.told() == {} for one in alone.bench.parts_of(Air).values())
    assert room.strays > 0
    for word in ("predator", "prey"):
        before, after = getattr(right, word).said, getattr(wrong, word).said
        pairs = zip(before.stimulus.sonars, after.stimulus.sonars, strict=True)
        assert any(phantom < true for true, phantom in pairs)


# -- Planted faults are seen ------------------------------------------------------------------


def changed(subject: Subject, chip: str, old: str, new: str, tokenizer: Tokenizer) -> Subject:
    """A robot with one thing else in a program."""
    source = subject.sources[chip]
    assert old in source
    image = tokenizer.compile(source.replace(old, new, 1), subject.files[chip]).image
    return replace(subject, images={**subject.images, chip: image})


def test_swapped_rows_of_the_gait_are_seen(
    predator: Subject,
    prey: Subject,
    numbers: WorldNumbers,
    figure_7: NDArray[np.float64],
    tokenizer: Tokenizer,
) -> None:
    """The first decision is RIGHT_FORWARD; its table becomes that of LEFT_FORWARD."""
    rows = "DATA    SwingC, 0,", "DATA    SwingD, 0,"
    faulty = changed(predator, "locomotion", *rows, tokenizer)
    difference = hunt(faulty, prey, numbers, figure_7, STEPS).difference
    assert difference is not None
    assert (difference.step, difference.what) == (1, "predator movement")
    assert "from frame 2 on" in difference.text()


def test_one_byte_of_one_pose_is_seen(
    predator: Subject,
    prey: Subject,
    numbers: WorldNumbers,
    figure_7: NDArray[np.float64],
    tokenizer: Tokenizer,
) -> None:
    rows = "221, 154, 221, 164, 211, 164", "221, 154, 221, 164, 210, 164"
    faulty = changed(predator, "locomotion", *rows, tokenizer)
    difference = hunt(faulty, prey, numbers, figure_7, STEPS).difference
    assert difference is not None
    assert "RM_horizontal" in difference.text()


def test_two_servos_on_each_others_pins_are_seen(
    predator: Subject, prey: Subject, numbers: WorldNumbers, figure_7: NDArray[np.float64]
) -> None:
    text = bench_text(predator.robot)
    crossed = (
        text.replace("locomotion.P0", "locomotion.P99")
        .replace('"locomotion.P2"', '"locomotion.P0"')
        .replace("locomotion.P99", "locomotion.P2")
    )
    assert crossed != text
    texts = {"predator": crossed, "prey": bench_text(prey.robot)}
    difference = hunt(predator, prey, numbers, figure_7, STEPS, texts=texts).difference
    assert difference is not None
    assert "LF_horizontal" in difference.text()
    assert "LM_horizontal" in difference.text()


def test_another_genome_is_seen_at_the_gene_that_differs(
    predator: Subject, prey: Subject, numbers: WorldNumbers, figure_7: NDArray[np.float64]
) -> None:
    """The chip has the reference genome; the simulator one whose state 16 answers otherwise."""
    assert predator.genome is not None
    bits = list(predator.genome.bits)
    bits[16 * 3] = "1" if bits[16 * 3] == "0" else "0"
    other = Genome("".join(bits), predator.genome.robot)
    looks = episode_of(other, numbers, figure_7, STEPS).looks
    first = int(np.argmax(looks[:, 7] == 16)) + 1
    difference = hunt(predator, prey, numbers, figure_7, STEPS, genome=other).difference
    assert difference is not None
    assert (difference.step, difference.what) == (first, "predator command")


def test_a_robot_whose_wiring_lost_a_sonar_stops_agreeing(
    predator: Subject, prey: Subject, numbers: WorldNumbers, figure_7: NDArray[np.float64]
) -> None:
    text = bench_text(predator.robot)
    text += '\n[fault.dead]\nkind = "no_echo"\npart = "sonar_left"\n'
    texts = {"predator": text, "prey": bench_text(prey.robot)}
    difference = hunt(predator, prey, numbers, figure_7, STEPS, texts=texts).difference
    assert difference is not None
    assert (difference.step, difference.what) == (1, "predator reading")


def test_a_robot_that_says_nothing_of_a_decision_is_seen(
    predator: Subject,
    prey: Subject,
    numbers: WorldNumbers,
    figure_7: NDArray[np.float64],
    tokenizer: Tokenizer,
) -> None:
    lines = "  GOSUB Report\n", "  IF tries = 0 THEN GOSUB Report\n"
    faulty = changed(predator, "main", *lines, tokenizer)
    difference = hunt(faulty, prey, numbers, figure_7, STEPS).difference
    assert difference is not None
    assert difference.what == "predator reading"
    assert difference.observed == "nothing said"


# -- The referee ------------------------------------------------------------------------------


def test_both_robots_go_on_on_one_tick_and_poses_change_there_only(
    predator: Subject, prey: Subject, numbers: WorldNumbers, figure_7: NDArray[np.float64]
) -> None:
    colony = Colony(predator, prey, numbers, figure_7)
    probes = {}
    for word in colony.players:
        probe = Probe(f"{word}_rises", colony.bench.clock, colony.bench.wire(f"{word}_step"))
        probes[word] = colony.bench.add_part(probe)
    seen = []
    for _ in range(3):
        before = colony.pair
        step = colony.step()
        assert step is not None
        seen.append(step.time_ns)
        assert colony.pair != before
    colony.bench.run(colony.bench.clock.now_ns + 1)
    rises = {
        word: [edge.time_ns for edge in probe.edges if edge.level] for word, probe in probes.items()
    }
    assert rises["predator"] == rises["prey"]
    assert rises["predator"][1:] == seen  # the first rise is that of centred legs
    assert colony.referee.early_ns > 0  # and the referee had something to hold


def test_no_servo_goes_limp(
    predator: Subject, prey: Subject, numbers: WorldNumbers, figure_7: NDArray[np.float64]
) -> None:
    colony = Colony(predator, prey, numbers, figure_7)
    colony.play(3)
    pulses = [servo.pulses for servo in colony.bench.parts_of(Servo).values()]
    assert len(pulses) == 24
    assert all(one.taken > 100 and one.limp == one.odd == 0 for one in pulses)
