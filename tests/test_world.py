"""The compiled world against the oracle of `oracle.py`: counts, states, commands and poses."""

import itertools
import math
from dataclasses import dataclass, field

import numpy as np
import oracle as by_angles
import pytest
from numpy.typing import NDArray

from cgagen.robot import Arena, Robot
from cgagen.words import COMMANDS, Role
from sim.episode import play_recorded
from sim.model import STEPS, words_of
from sim.numbers import Options, WorldNumbers, world_numbers
from sim.starts import draw_starts
from tests.oracle import Look, Oracle, Pose
from tests.pursuit import (
    Bits,
    genes_of,
    hunter_bits,
    oracle_of,
    other_world,
    poses_of,
    random_bits,
    shipped,
)

TOLERANCE = 1e-9
"""Units and radians: how far the two may differ, and how near to a boundary a tie is."""


@dataclass
class Tally:
    """What a comparison has gone through."""

    steps: int = 0
    ties: int = 0
    captures: int = 0
    states: set[int] = field(default_factory=set)
    commands: set[int] = field(default_factory=set)
    answers: set[int] = field(default_factory=set)


def nudged(pose: Pose) -> list[Pose]:
    """Return a pose, and all that differ from it by the tolerance in one coordinate."""
    steps = [tuple(sign * (axis == n) for n in range(3)) for axis in range(3) for sign in (-1, 1)]
    to_deg = math.degrees(TOLERANCE)
    return [pose] + [
        Pose(pose.x + TOLERANCE * x, pose.y + TOLERANCE * y, pose.heading_deg + to_deg * turn)
        for x, y, turn in steps
    ]


def is_tie(twin: Oracle, at: tuple[Pose, Pose], genes: list[int], row: list[int]) -> bool:
    """Say whether a look that differs can be had from poses within the tolerance.

    Every reading must be one that the oracle gives near by, and the decisions must be the
    oracle's for these readings.
    """
    seen = [
        (*look.reading, *look.prey_reading)
        for predator, prey in itertools.product(*map(nudged, at))
        for look in [twin.look(predator, prey, genes)]
    ]
    readings = (*row[:7], *row[9:17])
    near = all(
        value in values for value, values in zip(readings, zip(*seen, strict=True), strict=True)
    )
    state = by_angles.state_of(tuple(row[:7]), twin.masking, twin.limits)
    answer = by_angles.answer_of(tuple(row[9:17]), twin.prey, twin.policy)
    decided = [state, genes[state], COMMANDS[Role.PREY].index(answer)]
    return near and decided == [row[7], row[8], row[17]]


def row_of(look: Look) -> list[int]:
    return [*look.reading, look.state, look.command, *look.prey_reading, look.answer]


def assert_close(pose: NDArray[np.float64], predator: Pose, prey: Pose) -> None:
    px, py, pc, ps, qx, qy, qc, qs, _ = pose.tolist()
    for (x, y, c, s), twin in (((px, py, pc, ps), predator), ((qx, qy, qc, qs), prey)):
        heading = math.radians(twin.heading_deg)
        apart = (x - twin.x, y - twin.y, c - math.cos(heading), s - math.sin(heading))
        assert max(map(abs, apart)) <= TOLERANCE, (pose, predator, prey)


def compare(
    twin: Oracle,
    numbers: WorldNumbers,
    bits: Bits,
    start: NDArray[np.float64],
    tally: Tally,
    steps: int = STEPS,
) -> None:
    """Play one episode on both sides and compare every step, up to a tie."""
    poses, looks = play_recorded(words_of(bits[None])[:, 0], start[None], steps, numbers)
    genes, at = genes_of(bits), poses_of(start)
    was_captured = False
    for n, after in enumerate(twin.play(genes, *at, steps)):
        if after.look is not None:
            row = looks[n].tolist()
            if row != row_of(after.look):
                assert is_tie(twin, at, genes, row), (at, row, row_of(after.look))
                tally.ties += 1
                return
            tally.steps += 1
            tally.states.add(after.look.state)
            tally.commands.add(after.look.command)
            tally.answers.add(after.look.answer)
        at = after.predator, after.prey
        assert_close(poses[n], *at)
        distance = float(poses[n, 8])
        assert abs(distance - after.distance) <= TOLERANCE
        scoring = numbers.scoring
        if (scoring.longest - distance > scoring.capture_score) != twin.caught(after.distance):
            margin = twin.arena.longest_units - after.distance - twin.arena.capture_score_units
            assert abs(margin) <= TOLERANCE
            tally.ties += 1
            return
        tally.captures += after.captured and not was_captured
        was_captured = after.captured


def compare_many(
    world: tuple[Robot, Robot, Arena], options: Options, randoms: int, hunters: int, seed: int
) -> Tally:
    """Compare episodes of random genomes and of hunters from random starts."""
    predator, prey, arena = world
    numbers, twin = world_numbers(*world, options), oracle_of(*world, options)
    rng = np.random.default_rng(seed)
    genomes = np.concatenate([random_bits(rng, randoms), hunter_bits(rng, hunters)])
    radii = predator.body_radius_units, prey.body_radius_units
    starts = draw_starts(rng, len(genomes), arena.side_units, radii, arena.start_gap_units)
    tally = Tally()
    for bits, start in zip(genomes, starts, strict=True):
        compare(twin, numbers, bits, start, tally)
    return tally


def test_a_hundred_thousand_steps_of_the_shipped_robots() -> None:
    tally = compare_many(shipped(), Options(), randoms=470, hunters=80, seed=11)
    assert tally.steps >= 100_000
    assert tally.ties <= tally.steps / 100_000
    assert tally.captures >= 10
    assert len(tally.states) >= 26  # masking leaves 40, bodies and walls fewer
    assert tally.commands == set(range(8))
    assert tally.answers == {0, 1, 2, 3, 4, 5, 6, 7}


OPTIONS = [
    Options(after, masking, light, policy, walls)
    for after in ("hold", "go_on")
    for masking in (True, False)
    for light in ("dark", "ambient")
    for policy in ("turn", "wall", "wary")
    for walls in ("slide", "stop")
]


def test_every_combination_of_options() -> None:
    tallies = [
        compare_many(shipped(), options, randoms=1, hunters=2, seed=seed)
        for seed, options in enumerate(OPTIONS)
    ]
    assert sum(tally.ties for tally in tallies) == 0
    assert sum(tally.steps for tally in tallies) > 20_000


@pytest.mark.parametrize(
    "options",
    [Options(), Options("go_on", False, "ambient", "wary", "stop")],
    ids=["as filed", "all other options"],
)
def test_a_world_in_which_every_number_differs(options: Options) -> None:
    tally = compare_many(other_world(), options, randoms=25, hunters=25, seed=5)
    assert tally.ties == 0
    assert tally.steps > 5_000
    assert tally.captures >= 5
    assert len(tally.states) >= 24


@pytest.mark.parametrize("masking", [True, False])
@pytest.mark.parametrize("world", [shipped(), other_world()], ids=["shipped", "other"])
def test_looks_from_close_poses(world: tuple[Robot, Robot, Arena], masking: bool) -> None:
    """Robots near each other and near walls see what long walks seldom show."""
    options = Options(after_capture="go_on", masking=masking)
    numbers, twin = world_numbers(*world, options), oracle_of(*world, options)
    rng, tally, side = np.random.default_rng(6), Tally(), world[2].side_units
    genomes = random_bits(rng, 10)
    for n in range(2_000):
        predator = rng.uniform(10.6, side - 10.6, 2)
        prey = np.clip(predator + rng.normal(0, 30, 2), 10.6, side - 10.6)
        turns = rng.uniform(0, 2 * np.pi, 2)
        headings = [(np.cos(turn), np.sin(turn)) for turn in turns]
        start = np.concatenate((predator, headings[0], prey, headings[1]))
        compare(twin, numbers, genomes[n % 10], start, tally, steps=1)
    assert tally.ties == 0
    assert len(tally.states) >= (24 if masking else 30)


def test_robots_on_one_point_see_walls_only() -> None:
    """There a bearing means nothing; the oracle has to be told that the other is not there."""
    options = Options(after_capture="go_on")
    numbers, twin = world_numbers(*shipped(), options), oracle_of(*shipped(), options)
    corner = np.array([[10.6, 10.6, -0.6, 0.8, 10.6, 10.6, 0.28, 0.96]])
    _, looks = play_recorded(np.zeros(3, np.int64), corner, 1, numbers)
    at = poses_of(corner[0])
    for pose, robot, columns in (
        (at[0], twin.predator, looks[0, :3]),
        (at[1], twin.prey, looks[0, 9:15]),
    ):
        away = Pose(1e6, 1e6, 0.0)
        walls = [twin.sonar(robot, robot, sonar, pose, away) for sonar in robot.sonars]
        assert columns.tolist() == walls
    assert looks[0, 5:7].tolist() == [0, 0]


def test_the_oracle_finds_the_nearest_wall_of_a_cone() -> None:
    """Many rays, far apart, can only find a wall that is a little farther."""
    rng = np.random.default_rng(2)
    for _ in range(100):
        x, y, axis_deg, cone_deg = rng.uniform((5, 5, -400, 5), (295, 295, 400, 150)).tolist()
        nearest = by_angles.wall_in_cone(x, y, axis_deg, cone_deg, 300.0)
        rays = np.linspace(axis_deg - cone_deg / 2, axis_deg + cone_deg / 2, 1001).tolist()
        swept = min(by_angles.wall_along_ray(x, y, ray, 300.0) for ray in rays)
        assert nearest <= swept + 1e-9
        assert swept <= nearest * 1.002
