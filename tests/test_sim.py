"""Around the step: scores, genomes, episodes, and worlds that are refused."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import sim
from cgagen import counts
from cgagen.errors import RobotError
from cgagen.robot import values
from cgagen.words import GENES, Situation, state_of
from sim.episode import heading_deg, play_episode, visits_of
from sim.jit import KERNEL_FILES
from sim.model import World, with_distance, words_of
from sim.numbers import Options, Scoring, world_numbers
from sim.scalar import play_scalar
from sim.world import captured, score_of
from tests.pursuit import (
    arena_from,
    content,
    genes_of,
    hunter_bits,
    oracle_of,
    poses_of,
    random_bits,
    robot_from,
    shipped,
)

PREDATOR, PREY, ARENA = shipped()


NUMBERS = world_numbers(PREDATOR, PREY, ARENA)


# -- scores ---------------------------------------------------------------------------------------

SCORING = Scoring(424.26, 403.05)


@pytest.mark.parametrize(
    ("distance", "score"),
    [
        (0.0, 2 * 424.26),
        (10.0, 2 * 414.26),
        (21.2, 2 * 403.06),
        (21.22, 403.04),
        (100.0, 324.26),
        (424.26, 0.0),
    ],
)
def test_equation_1_and_the_doubling(distance: float, score: float) -> None:
    assert score_of(distance, SCORING) == pytest.approx(score, abs=1e-9)
    assert bool(captured(distance, SCORING)) == (distance < 21.21)


def test_exactly_at_the_capture_score_nothing_is_caught() -> None:
    """Numbers that binary can hold: 400 - 100 is not more than 300."""
    scoring = Scoring(400.0, 300.0)
    assert not captured(100.0, scoring)
    assert score_of(100.0, scoring) == 300.0
    assert captured(99.9999, scoring)
    assert score_of(99.0, scoring) == 602.0


def test_the_numbers_of_equation_1_are_the_papers() -> None:
    assert tuple(NUMBERS.scoring) == (424.26, 403.05)


def test_equation_2_gives_the_first_step_twice() -> None:
    """Standing from the start on; the largest value of a step is 4 x 424.26. Ref: S1 III.A."""
    still = world_with_no_steps()
    start = np.array([[100.0, 100, 1, 0, 200, 100, 0, 1]])
    steps = play_episode(np.zeros(3, np.int64), start, 4, still)
    assert [step.score for step in steps] == pytest.approx(
        [324.26 * factor for factor in (2, 1.25, 1 + 1 / 9, 1.0625)]
    )
    assert not any(step.captured for step in steps)
    on_one_point = np.array([[100.0, 100, 1, 0, 100, 100, 0, 1]])
    first = play_episode(np.zeros(3, np.int64), on_one_point, 1, still)[0]
    assert first.captured
    assert first.score == pytest.approx(1697.04)


def world_with_no_steps():  # type: ignore[no-untyped-def]
    """Return a world in which no movement moves."""
    still = [
        replace(
            robot,
            steps=tuple(
                replace(step, along_units=0.0, right_units=0.0, turn_deg=0.0)
                for step in robot.steps
            ),
        )
        for robot in (PREDATOR, PREY)
    ]
    return world_numbers(still[0], still[1], ARENA)


# -- genomes --------------------------------------------------------------------------------------


def test_words_hold_the_bits_of_every_gene() -> None:
    bits = random_bits(np.random.default_rng(1), 40)
    words = words_of(bits)
    assert words.dtype == np.int64
    for n, row in enumerate(bits):
        for state, command in enumerate(genes_of(row)):
            for bit in range(3):
                assert int(words[bit, n]) >> state & 1 == command >> bit & 1


@given(st.lists(st.integers(0, 7), min_size=GENES, max_size=GENES))
@settings(max_examples=25)
def test_any_genes_survive_the_packing(genes: list[int]) -> None:
    row = np.array([gene >> bit & 1 for gene in genes for bit in (2, 1, 0)], np.uint8)
    words = [int(word) for word in words_of(row[None])[:, 0]]
    assert genes == [sum((words[b] >> n & 1) << b for b in range(3)) for n in range(GENES)]


# -- episodes -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "options",
    [Options(), Options(after_capture="go_on"), Options(walls="stop", light="ambient")],
    ids=["hold", "go on", "stop"],
)
@pytest.mark.parametrize("count", [1, 7, 8, 9, 200])
def test_an_episode_agrees_with_the_batch(options: Options, count: int) -> None:
    world = World(*shipped(), options, steps=count)
    rng = np.random.default_rng(2)
    bits = np.concatenate([hunter_bits(rng, 10), random_bits(rng, 4)])
    starts = world.draw_starts(rng, 2)
    words = words_of(bits)
    scores, caught = world.play(words, starts)
    for episode, (score, at) in enumerate(zip(scores, caught, strict=True)):
        genome, start = divmod(episode, 2)
        steps = play_episode(words[:, genome], starts[start : start + 1], count, world.numbers)
        assert [step.number for step in steps] == list(range(1, count + 1))
        assert sum(step.score for step in steps) == pytest.approx(score, rel=1e-13)
        first = next((step.number for step in steps if step.captured), 0)
        assert first == at


def test_an_episode_agrees_with_the_oracle() -> None:
    world, twin = World(*shipped()), oracle_of(*shipped())
    rng = np.random.default_rng(3)
    bits, starts = hunter_bits(rng, 1, changed=0.0), world.draw_starts(rng, 12)
    captures = 0
    for start in starts:
        steps = play_episode(words_of(bits)[:, 0], start[None], 200, world.numbers)
        twins = list(twin.play(genes_of(bits[0]), *poses_of(start), 200))
        for step, other in zip(steps, twins, strict=True):
            assert step.score == pytest.approx(other.score, abs=1e-6)
            assert step.distance_units == pytest.approx(other.distance, abs=1e-9)
            assert step.captured == other.captured
            assert step.predator[:2] == pytest.approx(other.predator[:2], abs=1e-9)
            if other.look:
                assert tuple(step.reading) == other.look.reading
                assert tuple(step.prey_reading) == other.look.prey_reading
                assert step.state == other.look.state == state_of(step.obstacle, step.target)
                assert step.command == other.look.command
                assert step.movement is PREDATOR.steps[step.command].movement
                assert step.prey_command == other.look.answer
                assert step.prey_movement is PREY.steps[step.prey_command].movement
        captures += steps[-1].captured
    assert captures >= 2


def test_a_capture_holds_both_and_scores_double_to_the_end() -> None:
    world = World(*shipped())
    rng = np.random.default_rng(4)
    bits, starts = hunter_bits(rng, 1, changed=0.0), world.draw_starts(rng, 20)
    _, caught = world.play(words_of(bits), starts)
    at = int(np.argmax(caught > 0))
    number = int(caught[at])
    assert 0 < number < 200
    steps = play_episode(words_of(bits)[:, 0], starts[at : at + 1], 200, world.numbers)
    held = steps[number - 1 :]
    assert {(step.predator, step.prey) for step in held} == {(held[0].predator, held[0].prey)}
    assert [step.captured for step in steps] == [False] * (number - 1) + [True] * len(held)
    for step in held:
        plain = 2 * (424.26 - step.distance_units)
        assert step.score == pytest.approx(plain + plain / step.number**2)


def test_fitness_is_the_mean_step_score() -> None:
    world = World(*shipped())
    rng = np.random.default_rng(5)
    bits, starts = hunter_bits(rng, 6), world.draw_starts(rng, 10)
    scores, caught = world.play(words_of(bits), starts)
    result = world.evaluate(bits, starts)
    assert result.fitness == pytest.approx(scores.reshape(6, 10).sum(axis=1) / 2000)
    assert result.captured == pytest.approx((caught.reshape(6, 10) > 0).mean(axis=1))


def test_no_episodes_are_no_scores() -> None:
    for threads in (1, 2):
        world = World(*shipped(), threads=threads)
        scores, caught = world.play(np.zeros((3, 0), np.int64), np.zeros((0, 8)))
        assert scores.shape == caught.shape == (0,)
        world.close()


@pytest.mark.parametrize("after", ["hold", "go_on"])
def test_the_scalar_loop_scores_like_the_lanes(after: str) -> None:
    """It adds in another order, so the last digits differ."""
    world = World(*shipped(), Options(after_capture=after), steps=90)
    rng = np.random.default_rng(8)
    bits, starts = hunter_bits(rng, 20), world.draw_starts(rng, 4)
    words, scores = words_of(bits), np.empty(80)
    play_scalar(words, with_distance(starts), 90, world.numbers, scores)
    assert scores == pytest.approx(world.play(words, starts)[0], rel=1e-12)


@pytest.mark.parametrize("after", ["hold", "go_on"])
def test_visits_count_states_up_to_a_holding_capture(after: str) -> None:
    world = World(*shipped(), Options(after_capture=after), steps=80)
    rng = np.random.default_rng(6)
    bits, starts = hunter_bits(rng, 1, changed=0.0), world.draw_starts(rng, 15)
    words = words_of(bits)
    visits = visits_of(words[:, 0], starts, 80, world.numbers)
    wanted = [0] * 64
    for start in starts:
        for step in play_episode(words[:, 0], start[None], 80, world.numbers):
            wanted[step.state] += 1
            if step.captured and after == "hold":
                break
    assert visits.tolist() == wanted
    assert (sum(wanted) < 15 * 80) == (after == "hold")
    assert sum(count > 0 for count in wanted) > 8


def test_headings_read_back_from_0_to_360() -> None:
    assert heading_deg(1.0, -1e-12) == 0.0
    assert heading_deg(-1.0, 0.0) == 180.0
    assert heading_deg(0.6, -0.8) == pytest.approx(306.869898)


# -- the cache of machine code -------------------------------------------------------------------


def test_the_digest_covers_every_file_of_the_step() -> None:
    """An edit of a file that the digest forgets would run old machine code."""
    digested, folder = {path.resolve() for path in KERNEL_FILES}, Path(sim.__file__).parent
    wanted, found = ["model"], set()
    while wanted:
        path = (folder / f"{wanted.pop()}.py").resolve()
        if path not in found:
            found.add(path)
            wanted += re.findall(r"^from sim\.(\w+) import", path.read_text("utf-8"), re.MULTILINE)
    assert len(found) >= 9
    assert found <= digested
    for module in (counts, values):  # the conversion, and the limits as the step reads them
        assert Path(module.__file__).resolve() in digested


# -- worlds that are refused ----------------------------------------------------------------------


def test_bodies_must_be_able_to_come_within_the_capture_distance() -> None:
    """A capture that the bodies keep from happening. Ref: S1 III.A for 424.26 and 403.05."""
    changed = content("servobot-predator")
    changed["body"]["radius_units"] = 10.62
    with pytest.raises(RobotError, match=r"21\.22 units.*21\.21"):
        world_numbers(robot_from(changed), PREY, ARENA)
    changed["body"]["radius_units"] = 10.6
    assert world_numbers(robot_from(changed), PREY, ARENA).predator.radius == 10.6


def test_starts_must_not_be_captures() -> None:
    arena = arena_from(content("colony") | {"start_gap_units": 20})
    with pytest.raises(RobotError, match=r"start_gap_units.*21\.21"):
        world_numbers(PREDATOR, PREY, arena)


def test_bodies_must_fit_the_arena() -> None:
    arena = arena_from(content("colony") | {"side_units": 50, "start_gap_units": 25})
    changed = content("servobot-prey")
    changed["body"]["radius_units"] = 13
    with pytest.raises(RobotError, match=r"radius_units.*colony"):
        world_numbers(PREDATOR, robot_from(changed), arena)


def test_roles_must_not_be_swapped() -> None:
    with pytest.raises(RobotError, match="prey where the predator"):
        world_numbers(PREY, PREY, ARENA)
    with pytest.raises(RobotError, match="predator where the prey"):
        world_numbers(PREDATOR, PREDATOR, ARENA)


def test_an_unknown_policy_is_refused_with_the_known_ones() -> None:
    with pytest.raises(RobotError, match=r"'brave'.*turn, wall, wary"):
        world_numbers(PREDATOR, PREY, ARENA, Options(prey_policy="brave"))


def test_options_win_over_files() -> None:
    ambient = world_numbers(PREDATOR, PREY, ARENA, Options(light="ambient"))
    assert ambient.predator.limits.lamp_left.range == 612
    assert NUMBERS.predator.limits.lamp_right.range == 2587
    wary = world_numbers(PREDATOR, PREY, ARENA, Options(prey_policy="wary"))
    assert (NUMBERS.prey.reflex.alarm, wary.prey.reflex.alarm) == (7079, 9439)
    others = world_numbers(PREDATOR, PREY, ARENA, Options("go_on", False, None, None, "stop"))
    assert (NUMBERS.hold, NUMBERS.predator.masking, NUMBERS.stop_at_walls) == (True, True, False)
    assert (others.hold, others.predator.masking, others.stop_at_walls) == (False, False, True)


def test_situations_and_states_go_together() -> None:
    assert state_of(Situation.FAR_FRONT, Situation.FAR_FRONT) == 63


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (Options(walls="bounce"), "walls: 'bounce' is not slide or stop"),
        (Options(after_capture="Hold"), "after_capture: 'Hold' is not hold or go_on"),
        (Options(light="dusk"), "light: 'dusk' is not dark or ambient"),
    ],
)
def test_an_option_with_a_typo_is_refused(options: Options, sentence: str) -> None:
    with pytest.raises(RobotError, match=sentence):
        world_numbers(PREDATOR, PREY, ARENA, options)
