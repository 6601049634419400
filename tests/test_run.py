"""What a run leaves in its folder, for one trial and for several."""

import csv
import itertools
from dataclasses import replace

import numpy as np
import pytest

from cgagen import genome
from cgagen.errors import StoppedError
from cgagen.run import start
from cgagen.run.streams import Purpose, stream
from tests.run_cases import contents, resume_toy, unbroken
from tests.toy_run import BuggyFactory, FatalFactory, ToyFactory, ToyScores, ToyWorld, record


def rows_of(data):
    return list(csv.DictReader(data.decode().splitlines()))


# --- what lies in the folder


def test_the_folder_has_the_files_of_the_house():
    assert set(unbroken(1)[1]) == {
        ".lock",
        "0-run.toml",
        "1-predator.toml",
        "1-prey.toml",
        "1-arena.toml",
        "2-training.csv",
        "2-fitness.csv",
        "2-population-g001.csv",
        "2-population-g015.csv",
        "2-population-g035.csv",
        "2-checkpoint.npz",
        "best.genome",
    }
    assert unbroken(1)[1]["1-prey.toml"] == b"prey\n"


def test_the_same_input_gives_the_same_bytes(tmp_path):
    start(tmp_path / "elsewhere", record(), ToyFactory(), workers=2)
    assert contents(tmp_path / "elsewhere") == unbroken(1)[1]


def test_another_seed_gives_other_populations(tmp_path):
    start(tmp_path / "run", record(seed=8), ToyFactory())
    other = contents(tmp_path / "run")
    assert other["2-population-g001.csv"] != unbroken(1)[1]["2-population-g001.csv"]


def test_fitness_has_the_first_every_tenth_and_the_last_generation():
    rows = rows_of(unbroken(1)[1]["2-fitness.csv"])
    assert [row["generation"] for row in rows] == ["1", "10", "15", "20", "30", "35"]
    training = rows_of(unbroken(1)[1]["2-training.csv"])
    assert [int(row["generation"]) for row in training] == list(range(1, 36))
    for row in rows + training:
        assert float(row["worst"]) <= float(row["mean"]) <= float(row["best"])
        assert 0 <= float(row["captured"]) <= 1


def test_a_population_is_written_with_the_fitness_that_it_has():
    rows = rows_of(unbroken(1)[1]["2-population-g015.csv"])
    assert [int(row["individual"]) for row in rows] == list(range(16))
    bits = np.array([list(row["bits"]) for row in rows], np.uint8)
    world = ToyWorld()
    fixed = world.draw_starts(stream(0, 0, 0, Purpose.FIXED_STARTS), 100)
    own = world.draw_starts(stream(7, 1, 15, Purpose.STARTS), 10)
    assert [float(row["fixed_fitness"]) for row in rows] == list(
        world.evaluate(bits, fixed).fitness
    )
    assert [float(row["training_fitness"]) for row in rows] == list(
        world.evaluate(bits, own).fitness
    )
    reported = next(r for r in rows_of(unbroken(1)[1]["2-fitness.csv"]) if r["generation"] == "15")
    assert float(reported["mean"]) == np.mean([float(row["fixed_fitness"]) for row in rows])


def test_best_genome_is_the_best_of_the_fixed_starts_and_says_where_from():
    outcome, all_files = unbroken(1)
    best = genome.parse(all_files["best.genome"].decode(), "best.genome")
    rows = rows_of(all_files["2-fitness.csv"])
    highest = max(rows, key=lambda row: float(row["best"]))
    assert best.origin.fitness == float(highest["best"])
    assert best.origin.generation == int(highest["generation"])
    assert (best.origin.seed, best.origin.trial, best.robot) == (7, 1, "servobot-predator")
    assert best.origin.robot_digest == "ab12"
    world = ToyWorld()
    fixed = world.draw_starts(stream(0, 0, 0, Purpose.FIXED_STARTS), 100)
    assert world.evaluate(best.array()[None], fixed).fitness[0] == best.origin.fitness
    assert outcome.best.best.fitness == best.origin.fitness


def test_of_equal_individuals_the_earliest_is_best(tmp_path):
    class Flat(ToyWorld):
        def evaluate(self, bits, starts):
            return ToyScores(np.full(len(bits), 5.0), np.zeros(len(bits)))

    outcome = start(tmp_path / "run", record(), lambda threads: Flat())
    first = rows_of((tmp_path / "run/2-population-g001.csv").read_bytes())[0]
    assert outcome.best.best.generation == 1
    assert "".join(map(str, outcome.best.best.bits.tolist())) == first["bits"]


def test_all_seeds_and_trials_meet_the_same_fixed_starts(tmp_path):
    seen = []

    class Watching(ToyWorld):
        def evaluate(self, bits, starts):
            seen.append(starts.copy())
            return super().evaluate(bits, starts)

    for seed, trial in [(1, 1), (2, 1), (1, 2)]:
        settings = {"seed": seed, "first_trial": trial, "generations": 1}
        start(tmp_path / f"{seed}-{trial}", record(**settings), lambda threads: Watching())
    training, fixed = seen[0::2], seen[1::2]
    assert all(np.array_equal(fixed[0], other) for other in fixed)
    assert not any(np.array_equal(a, b) for a, b in itertools.combinations(training, 2))


def test_a_genetic_algorithm_that_mends_itself_is_seen_to_learn():
    rows = rows_of(unbroken(1)[1]["2-fitness.csv"])
    assert float(rows[-1]["mean"]) > float(rows[0]["mean"]) + 5


# --- several trials


def test_trials_in_processes_give_the_same_files(tmp_path):
    seen = []
    outcome = start(
        tmp_path / "run", record(trials=3), ToyFactory(), workers=2, observe=seen.append
    )
    assert contents(tmp_path / "run") == unbroken(3)[1]
    assert {progress.trial for progress in seen} == {1, 2, 3}
    assert outcome.best == replace(
        unbroken(3)[0].best, folder=outcome.best.folder, best=outcome.best.best
    )


def test_workers_run_nothing_of_the_folder_that_one_works_in(tmp_path, monkeypatch):
    for name in ("pickle", "runpy", "multiprocessing"):
        (tmp_path / f"{name}.py").write_text("open('armed', 'w').close()\n")
    monkeypatch.chdir(tmp_path)
    start(tmp_path / "run", record(trials=2), ToyFactory(), workers=2)
    assert not (tmp_path / "armed").exists()


def test_a_trial_of_several_is_the_trial_alone():
    for name, data in unbroken(1)[1].items():
        assert unbroken(3)[1][f"trial-1/{name}"] == data


def test_the_best_of_all_trials_is_on_top():
    outcome, all_files = unbroken(3)
    trials = [genome.parse(all_files[f"trial-{n}/best.genome"].decode(), "x") for n in (1, 2, 3)]
    best = max(trials, key=lambda one: one.origin.fitness)
    assert genome.parse(all_files["best.genome"].decode(), "x") == best
    assert outcome.best.trial == best.origin.trial


def test_a_killed_worker_is_a_sentence(tmp_path):
    with pytest.raises(StoppedError, match=r"SIGKILL.*cgagen resume"):
        start(tmp_path / "run", record(trials=2), FatalFactory(), workers=2)
    assert resume_toy(tmp_path / "run").trials[1].trial == 2


def test_a_bug_in_a_worker_is_not_hidden(tmp_path):
    with pytest.raises(RuntimeError, match="a planted bug"):
        start(tmp_path / "run", record(trials=2), BuggyFactory(), workers=2)
