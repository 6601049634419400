"""The numbers that the paper prints, each found where this project keeps it. Ref: S1 throughout.

What five whole trials come to is in `test_paper_trials.py`.
"""

import math

import numpy as np
import pytest

from cgagen.evolve import Settings, first_generation
from cgagen.robot import Robot
from cgagen.run import RunSettings
from cgagen.verbs.evolve import evolve_verb
from cgagen.verbs.simulate import simulate_verb
from cgagen.words import (
    BITS_PER_GENE,
    COMMANDS,
    GENES,
    GENOME_BITS,
    Movement,
    Role,
    Situation,
    situation_name,
)
from sim.episode import Step, play_episode
from sim.model import STEPS, World, words_of
from sim.numbers import world_numbers
from sim.starts import start_of
from tests.pursuit import shipped

PREDATOR, PREY, ARENA = shipped()
NUMBERS = world_numbers(PREDATOR, PREY, ARENA)
RADII = (PREDATOR.body_radius_units, PREY.body_radius_units)

Place = tuple[float, float, float]


def one_step(command: int, predator: Place, prey: Place = (40.0, 40.0, 10.0)) -> Step:
    """Return a step of a predator that always answers with one command."""
    row = np.array([command >> bit & 1 for bit in (2, 1, 0)] * GENES, np.uint8)
    start = start_of(predator, prey, ARENA.side_units, RADII)
    return play_episode(words_of(row[None])[:, 0], start, 1, NUMBERS)[0]


# -- arena (section II.C) -------------------------------------------------------------------------


def test_the_arena_is_300_units_and_8_feet() -> None:
    assert ARENA.side_units == 300
    assert ARENA.side_units / ARENA.units_per_in == 8 * 12
    assert 12 * ARENA.units_per_in == 37.5


@pytest.mark.parametrize(
    ("heading", "dx", "dy"),
    [(0, 7.5, -0.05), (90, 0.05, 7.5), (180, -7.5, 0.05), (270, -0.05, -7.5)],
)
def test_heading_0_is_east_and_left_turns_are_positive(
    heading: float, dx: float, dy: float
) -> None:
    after = one_step(0, (150, 150, heading)).predator
    assert (after[0] - 150, after[1] - 150) == pytest.approx((dx, dy))
    assert after[2] == pytest.approx((heading - 1.5) % 360)


def test_sonars_reach_across_the_whole_arena() -> None:
    """So "no object" must come from a limit, not from the range."""
    for robot in (PREDATOR, PREY):
        for sonar in robot.sonars:
            assert sonar.range_in * ARENA.units_per_in == 468.75 > math.hypot(300, 300)


# -- robots (section II) --------------------------------------------------------------------------


@pytest.mark.parametrize("robot", [PREDATOR, PREY], ids=["predator", "prey"])
def test_hexapods_with_twelve_servos_and_two_stamps(robot: Robot) -> None:
    servos = robot.servo_set.servos
    assert len({servo.leg for servo in servos}) == 6
    assert len(servos) == 12
    assert [servo.joint for servo in servos] == ["horizontal", "vertical"] * 6
    assert robot.main.model == "BS2p"
    assert robot.locomotion.model == "BS2"
    link = robot.link
    assert len(link.main_pins) == len(link.locomotion_pins) == 3
    used = [servo.pin for servo in servos] + list(link.locomotion_pins)
    assert len(set(used)) == 15
    assert max(used) < 16


def test_the_preys_sensors() -> None:
    bearings = sorted(sonar.bearing_deg for sonar in PREY.sonars)
    assert bearings == [30, 90, 150, 210, 270, 330]
    assert {(sonar.cone_deg, sonar.range_in) for sonar in PREY.sonars} == {(60, 150)}
    antennas = [(antenna.bearing_deg, antenna.length_in) for antenna in PREY.antennas]
    assert antennas == [(45, 10), (315, 10)]
    assert PREY.light is None


def test_the_predators_sensors() -> None:
    bearings = {sonar.name: sonar.bearing_deg for sonar in PREDATOR.sonars}
    assert bearings == {"front": 0, "right": 330, "left": 30}
    assert {(sonar.cone_deg, sonar.range_in) for sonar in PREDATOR.sonars} == {(60, 150)}
    antennas = [(antenna.bearing_deg, antenna.length_in) for antenna in PREDATOR.antennas]
    assert antennas == [(25, 9.5), (335, 9.5)]
    light = PREDATOR.light
    assert light is not None
    assert len(light.sensors) == 2
    assert light.ambient_range_in == 30
    assert light.dark_range_in > 30
    assert light.condition == "dark"


@pytest.mark.parametrize(
    ("bearing", "lit"), [(0, "both"), (7, "both"), (-7, "both"), (9, "left"), (-9, "right")]
)
def test_both_light_sensors_see_only_what_is_almost_dead_ahead(bearing: float, lit: str) -> None:
    direction = math.radians(bearing)
    prey = (150 + 90 * math.cos(direction), 150 + 90 * math.sin(direction), 5.0)
    reading = one_step(0, (150, 150, 0), prey).reading
    assert (reading.light_left > 0) == (lit in ("left", "both"))
    assert (reading.light_right > 0) == (lit in ("right", "both"))


def test_table_one() -> None:
    names = [str(movement) for movement in COMMANDS[Role.PREDATOR]]
    assert names == [
        "FORWARD", "BACKWARD", "RIGHT_FORWARD", "LEFT_FORWARD",
        "ROTATE_RIGHT", "ROTATE_LEFT", "BACKUP_RIGHT", "BACKUP_LEFT",
    ]  # fmt: skip
    assert COMMANDS[Role.PREY][1] is Movement.WAIT
    assert [str(movement) for movement in COMMANDS[Role.PREY]][2:] == names[2:]


def test_table_two() -> None:
    others = ["near_right", "far_right", "near_left", "far_left",
              "near_front", "middle_front", "far_front"]  # fmt: skip
    for what in ("object", "target"):
        assert [situation_name(one, what) for one in Situation] == [f"no_{what}", *others]


def test_the_first_gene_answers_no_object_and_no_target() -> None:
    """The paper's example of a chromosome begins with 001, Backward."""
    row = np.zeros((1, GENOME_BITS), np.uint8)
    row[0, :3] = (0, 0, 1)
    start = start_of((150, 150, 0), (40, 40, 0), 300.0, RADII)
    step = play_episode(words_of(row)[:, 0], start, 1, NUMBERS)[0]
    assert (step.obstacle, step.target, step.state) == (Situation.NO, Situation.NO, 0)
    assert step.movement is Movement.BACKWARD


def test_the_predator_heeds_the_nearest_obstacle() -> None:
    """A wall at its left and a nearer one ahead, then the other way round."""
    ahead = one_step(0, (275, 240, 0), (40, 40, 0))
    assert ahead.obstacle is Situation.NEAR_FRONT
    left = one_step(0, (200, 280, 20), (40, 40, 0))
    assert left.obstacle is Situation.NEAR_LEFT


def test_the_prey_prefers_front_to_middle_to_back() -> None:
    sides = [sonar.name.split("_")[0] for sonar in PREY.sonars]
    assert sides == ["front", "front", "left", "right", "rear", "rear"]


# -- movements (sections II.C and IV) -------------------------------------------------------------


def row_of(robot: Robot, movement: Movement) -> tuple[float, float, float]:
    step = next(step for step in robot.steps if step.movement is movement)
    return step.along_units, step.right_units, step.turn_deg


def test_the_two_published_rows_of_the_prey() -> None:
    assert row_of(PREY, Movement.FORWARD) == (5, 0.05, 4.6)
    assert row_of(PREY, Movement.RIGHT_FORWARD) == (2.38, 1.11, -39)


@pytest.mark.parametrize("robot", [PREDATOR, PREY], ids=["predator", "prey"])
def test_backing_up_right_turns_the_heading_left(robot: Robot) -> None:
    """And each Backup undoes its Forward: there and back is where it was."""
    for there, back in (
        (Movement.RIGHT_FORWARD, Movement.BACKUP_RIGHT),
        (Movement.LEFT_FORWARD, Movement.BACKUP_LEFT),
    ):
        along, right, turn = row_of(robot, there)
        back_along, back_right, back_turn = row_of(robot, back)
        assert turn == -back_turn
        heading = math.radians(turn)
        x = along + back_along * math.cos(heading) + back_right * math.sin(heading)
        y = -right + back_along * math.sin(heading) - back_right * math.cos(heading)
        assert math.hypot(x, y) < 0.02
    assert row_of(robot, Movement.BACKUP_RIGHT)[2] > 0


def test_both_robots_have_a_table_of_their_own() -> None:
    assert [step.turn_deg for step in PREDATOR.steps] != [step.turn_deg for step in PREY.steps]


# -- genetic algorithm (section III) --------------------------------------------------------------


def test_a_chromosome_has_192_bits() -> None:
    assert (GENES, BITS_PER_GENE, GENOME_BITS) == (64, 3, 192)
    assert len(Situation) ** 2 == GENES
    assert 2**BITS_PER_GENE == len(COMMANDS[Role.PREDATOR])


def test_the_settings_are_the_papers() -> None:
    evolution, run = Settings(), RunSettings()
    assert (evolution.population, evolution.bits) == (256, 192)
    assert evolution.mutation_rate == 0.003 / 100
    assert (evolution.selection, evolution.crossover) == ("roulette", "two-point")
    assert evolution.elite == 0
    assert (run.starts_per_generation, run.steps, STEPS) == (10, 200, 200)
    assert run.starts_per_generation * run.steps == 2000
    assert (run.generations, run.fixed_starts, run.evaluate_every) == (300, 100, 10)
    assert run.populations_at == (1, 100, 300)
    assert run.evolution == evolution


def test_the_command_line_has_the_same_defaults() -> None:
    defaults = {option.name: option.default for option in evolve_verb.params}
    run = RunSettings()
    assert defaults["generations"] == run.generations
    assert defaults["population"] == run.evolution.population
    assert defaults["mutation"] == run.evolution.mutation_rate
    assert defaults["starts"] == run.starts_per_generation
    assert defaults["steps"] == run.steps
    assert defaults["fixed_starts"] == run.fixed_starts
    assert defaults["evaluate_every"] == run.evaluate_every
    assert defaults["elite"] == 0


def test_the_first_population_is_random() -> None:
    bits = first_generation(Settings(), np.random.Generator(np.random.Philox(key=1)))
    assert bits.shape == (256, 192)
    assert 0.48 < bits.mean() < 0.52


def test_a_generation_inverts_one_and_a_half_bits() -> None:
    settings = Settings()
    flips = settings.population * settings.bits * settings.mutation_rate
    assert flips == pytest.approx(1.47, abs=0.01)


def test_the_score() -> None:
    """Equations 1 and 2, and the doubling beyond 95 % of the longest distance."""
    longest, capture = NUMBERS.scoring
    assert longest == pytest.approx(300 * math.sqrt(2), abs=0.005)
    assert capture == pytest.approx(0.95 * longest, abs=0.005)
    assert longest - capture == pytest.approx(21.21)
    assert (longest - capture) / ARENA.units_per_in == pytest.approx(6.79, abs=0.01)
    assert 4 * longest == pytest.approx(1697.04)


def test_fitness_is_the_sum_over_2000_scores() -> None:
    world = World(*shipped())
    rng = np.random.Generator(np.random.Philox(key=2))
    bits = first_generation(Settings(population=4), rng)
    starts = world.draw_starts(rng, 10)
    fitness = world.evaluate(bits, starts).fitness
    for row, value in zip(bits, fitness, strict=True):
        scores = [
            step.score
            for start in starts
            for step in play_episode(words_of(row[None])[:, 0], start[None], 200, world.numbers)
        ]
        assert len(scores) == 2000
        assert value == pytest.approx(sum(scores) / 2000)


# -- the real test (section IV) -------------------------------------------------------------------


def test_figure_7_is_the_default_of_simulate() -> None:
    defaults = {option.name: option.default for option in simulate_verb.params}
    assert str(defaults["predator"]) == "268.75,31.25,180"
    assert str(defaults["prey"]) == "15,150,90"
    assert defaults["steps"] == 100
    assert 300 - 268.75 == 31.25 == 10 * ARENA.units_per_in


def test_at_the_start_of_figure_7_the_lamp_is_out_of_sight() -> None:
    """Ref: S1 IV: the first moves are a blind search."""
    predator, prey = (268.75, 31.25, 180.0), (15.0, 150.0, 90.0)
    dx, dy = prey[0] - predator[0], prey[1] - predator[1]
    assert math.hypot(dx, dy) == pytest.approx(280, abs=5)
    step = one_step(0, predator, prey)
    assert step.target is Situation.NO
    light = PREDATOR.light
    assert light is not None
    assert light.dark_range_in * ARENA.units_per_in < math.hypot(dx, dy)
