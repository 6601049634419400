import csv
import errno
import itertools
import os
import random
import resource
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import toy_run
from toy_run import BuggyFactory, FatalFactory, ToyFactory, ToyScores, ToyWorld, record

from cgagen import files, genome
from cgagen.errors import RunError, StoppedError, StorageError
from cgagen.evolve import Settings
from cgagen.run import Inputs, RunSettings, read_record, resume, start, streams
from cgagen.run import folder as run_folder
from cgagen.run.streams import Purpose, stream

TOY = [sys.executable, toy_run.__file__]


def contents(folder):
    """All files of a folder, by their path in it."""
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
    }


def resume_toy(folder, **options):
    return resume(folder, lambda record: ToyFactory(), **options)


@pytest.fixture(scope="module")
def unbroken(tmp_path_factory):
    """A run of one trial that nobody disturbed."""
    folder = tmp_path_factory.mktemp("unbroken") / "run"
    outcome = start(folder, record(), ToyFactory())
    return outcome, contents(folder)


@pytest.fixture(scope="module")
def unbroken_trials(tmp_path_factory):
    """A run of three trials, one after the other."""
    folder = tmp_path_factory.mktemp("unbroken") / "run"
    outcome = start(folder, record(trials=3), ToyFactory())
    return outcome, contents(folder)


def rows_of(data):
    return list(csv.DictReader(data.decode().splitlines()))


# --- what lies in the folder


def test_the_folder_has_the_files_of_the_house(unbroken):
    assert set(unbroken[1]) == {
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
    assert unbroken[1]["1-prey.toml"] == b"prey\n"


def test_the_same_input_gives_the_same_bytes(unbroken, tmp_path):
    start(tmp_path / "elsewhere", record(), ToyFactory(), workers=2)
    assert contents(tmp_path / "elsewhere") == unbroken[1]


def test_another_seed_gives_other_populations(unbroken, tmp_path):
    start(tmp_path / "run", record(seed=8), ToyFactory())
    other = contents(tmp_path / "run")
    assert other["2-population-g001.csv"] != unbroken[1]["2-population-g001.csv"]


def test_fitness_has_the_first_every_tenth_and_the_last_generation(unbroken):
    rows = rows_of(unbroken[1]["2-fitness.csv"])
    assert [row["generation"] for row in rows] == ["1", "10", "15", "20", "30", "35"]
    training = rows_of(unbroken[1]["2-training.csv"])
    assert [int(row["generation"]) for row in training] == list(range(1, 36))
    for row in rows + training:
        assert float(row["worst"]) <= float(row["mean"]) <= float(row["best"])
        assert 0 <= float(row["captured"]) <= 1


def test_a_population_is_written_with_the_fitness_that_it_has(unbroken):
    rows = rows_of(unbroken[1]["2-population-g015.csv"])
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
    reported = next(r for r in rows_of(unbroken[1]["2-fitness.csv"]) if r["generation"] == "15")
    assert float(reported["mean"]) == np.mean([float(row["fixed_fitness"]) for row in rows])


def test_best_genome_is_the_best_of_the_fixed_starts_and_says_where_from(unbroken):
    outcome, all_files = unbroken
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


def test_a_genetic_algorithm_that_mends_itself_is_seen_to_learn(unbroken):
    rows = rows_of(unbroken[1]["2-fitness.csv"])
    assert float(rows[-1]["mean"]) > float(rows[0]["mean"]) + 5


# --- several trials


def test_trials_in_processes_give_the_same_files(unbroken_trials, tmp_path):
    seen = []
    outcome = start(
        tmp_path / "run", record(trials=3), ToyFactory(), workers=2, observe=seen.append
    )
    assert contents(tmp_path / "run") == unbroken_trials[1]
    assert {progress.trial for progress in seen} == {1, 2, 3}
    assert outcome.best == replace(
        unbroken_trials[0].best, folder=outcome.best.folder, best=outcome.best.best
    )


def test_a_trial_of_several_is_the_trial_alone(unbroken, unbroken_trials):
    for name, data in unbroken[1].items():
        assert unbroken_trials[1][f"trial-1/{name}"] == data


def test_the_best_of_all_trials_is_on_top(unbroken_trials):
    outcome, all_files = unbroken_trials
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


# --- interruptions


class Crash(BaseException):
    """What nothing catches: the power goes."""


@pytest.mark.parametrize("after", [False, True])
@pytest.mark.parametrize("trials", [1, 3])
def test_a_crash_at_any_file_then_resume(
    unbroken, unbroken_trials, tmp_path, monkeypatch, trials, after
):
    """The process ends just before, or just after, the n-th file takes its name; n = 1, 2, ..."""
    whole = (unbroken if trials == 1 else unbroken_trials)[1]
    real = os.replace
    for crash_at in itertools.count(1, 1 if trials == 1 else 7):
        folder, count = tmp_path / str(crash_at), itertools.count(1)

        def replaced(source, target, crash_at=crash_at, count=count):
            crash = next(count) == crash_at
            if crash and not after:
                Path(source).with_name(f".{Path(target).name}.abcdef12").write_bytes(b"half")
                raise Crash
            real(source, target)
            if crash:
                raise Crash

        monkeypatch.setattr("cgagen.files.os.replace", replaced)
        try:
            start(folder, record(trials=trials), ToyFactory())
            break
        except Crash:
            monkeypatch.setattr("cgagen.files.os.replace", real)
        if (folder / "0-run.toml").exists():
            resume_toy(folder)
        else:
            with pytest.raises(RunError, match="cgagen evolve --run"):
                resume_toy(folder)
            start(folder, record(trials=trials), ToyFactory())
        assert contents(folder) == whole, crash_at
    assert crash_at > 15 * trials


@pytest.mark.parametrize(
    ("trials", "workers", "pause_s", "latest_s"), [(1, 1, 0.015, 0.5), (2, 2, 0.04, 1.2)]
)
def test_killed_again_and_again_then_resumed(tmp_path, trials, workers, pause_s, latest_s):
    """41 evaluations take longer than the latest moment, so the first attempt is always killed."""
    whole, folder = tmp_path / "whole", tmp_path / "run"
    start(whole, record(trials=trials), ToyFactory())
    moments = random.Random(trials)
    verb, kills = "start", 0
    for _ in range(12):
        words = [verb, str(folder), str(pause_s), str(trials), str(workers)]
        process = subprocess.Popen([*TOY, *words], stdout=subprocess.PIPE)
        process.stdout.readline()  # it is past its imports
        time.sleep(moments.uniform(0.05, latest_s))
        process.kill()
        code = process.wait()
        process.stdout.close()
        if code == 0:
            break
        kills += 1
        verb = "resume" if (folder / "0-run.toml").exists() else "start"
    assert kills >= 1
    resume_toy(folder)  # workers of a killed parent notice within a generation
    assert contents(folder) == contents(whole)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize(("trials", "workers"), [(1, 1), (2, 2)])
def test_ctrl_c_is_a_sentence_and_exit_10(unbroken, tmp_path, number, trials, workers):
    folder = tmp_path / "run"
    words = ["start", str(folder), "0.03", str(trials), str(workers)]
    process = subprocess.Popen(
        [*TOY, *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    place = folder if trials == 1 else folder / "trial-1"
    for _ in range(200):
        if (place / "2-checkpoint.npz").exists():
            break
        time.sleep(0.05)
    if number == signal.SIGINT:
        os.killpg(process.pid, number)  # a terminal sends it to the whole group
    else:
        process.send_signal(number)
    _, sentence = process.communicate(timeout=30)
    assert process.returncode == 10, sentence
    assert f"cgagen resume {folder}`" in sentence
    assert len(sentence.strip().splitlines()) == 1
    resume_toy(folder)
    for name, data in unbroken[1].items():
        assert (place / name).read_bytes() == data


def test_stopped_between_any_two_generations(unbroken, tmp_path):
    folder, stops = tmp_path / "run", itertools.count()
    with pytest.raises(StoppedError, match="generation 0 of 35"):
        start(folder, record(), ToyFactory(), stopped=lambda: True)
    for generation in range(1, 35):
        calls = itertools.count()
        with pytest.raises(StoppedError, match=f"after generation {generation} of 35"):
            resume_toy(folder, stopped=lambda calls=calls: next(calls) > 0)
        next(stops)
    assert not resume_toy(folder).was_complete
    assert contents(folder) == unbroken[1]


def test_a_complete_run_stays_as_it_is(unbroken, tmp_path):
    for trials in (1, 2):
        folder = tmp_path / str(trials)
        start(folder, record(trials=trials), ToyFactory())
        before = {path: path.stat().st_mtime_ns for path in folder.rglob("*.*")}
        outcome = resume(folder, lambda record: pytest.fail("nothing is left to do"))
        assert outcome.was_complete
        assert {path: path.stat().st_mtime_ns for path in folder.rglob("*.*")} == before


# --- a disk that is full


@pytest.mark.parametrize("trials", [1, 2])
def test_a_full_disk_at_any_file(unbroken, tmp_path, monkeypatch, trials):
    real = os.fsync
    for full_at in itertools.count(1, 1 if trials == 1 else 3):
        folder, count = tmp_path / str(full_at), itertools.count(1)

        def fsync(handle, full_at=full_at, count=count):
            if next(count) >= full_at:
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            real(handle)

        monkeypatch.setattr("cgagen.files.os.fsync", fsync)
        try:
            start(folder, record(trials=trials), ToyFactory())
            break
        except StorageError:
            assert not (folder / "0-run.toml").exists()
            continue
        except StoppedError as error:
            sentence = str(error)
        finally:
            monkeypatch.setattr("cgagen.files.os.fsync", real)
        assert "No space left on device" in sentence
        assert f"cgagen resume {folder}`" in sentence
        assert "\n" not in sentence
        assert not [name for name in contents(folder) if run_folder._LEFTOVER.search(name)]
        resume_toy(folder)
        place = folder if trials == 1 else folder / "trial-1"
        assert contents(place) == unbroken[1]
    assert full_at > 15


def test_a_real_limit_on_files(unbroken, tmp_path):
    """The kernel refuses files above 4,200 bytes: the populations fit, the checkpoint does not."""
    folder = tmp_path / "run"
    done = subprocess.run(
        [*TOY, "start", str(folder), "0", "1", "1"],
        capture_output=True,
        check=False,
        text=True,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (4_200, 4_200)),
    )
    assert done.returncode == 10
    assert "2-checkpoint.npz" in done.stderr
    assert "cgagen resume" in done.stderr
    resume_toy(folder)
    assert contents(folder) == unbroken[1]


# --- folders that cannot be used


def test_a_folder_in_use_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(run_folder, "LOCK_WAIT_S", 0.1)
    folder = tmp_path / "run"
    start(folder, record(), ToyFactory())
    before = contents(folder)
    with run_folder.locked(folder), pytest.raises(RunError, match="in use"):
        resume_toy(folder)
    assert contents(folder) == before
    resume_toy(folder)


def test_a_folder_with_something_else_is_refused_and_untouched(tmp_path):
    for name in ("thesis.txt", "1-prey.toml"):
        folder = tmp_path / f"with {name}"
        folder.mkdir()
        (folder / name).write_text("mine")
        with pytest.raises(RunError, match=rf"not empty \(it holds {name}\)"):
            start(folder, record(), ToyFactory())
        assert contents(folder) == {name: b"mine"}


def test_a_run_is_never_overwritten(unbroken, tmp_path):
    folder = tmp_path / "run"
    start(folder, record(), ToyFactory())
    with pytest.raises(RunError, match=r"holds a run already.*cgagen resume"):
        start(folder, record(seed=9), ToyFactory())
    assert contents(folder) == unbroken[1]


def test_an_empty_folder_will_do(unbroken, tmp_path):
    start(tmp_path, record(), ToyFactory())
    assert contents(tmp_path) == unbroken[1]


def test_what_is_no_run_folder(tmp_path):
    (tmp_path / "file").write_text("x")
    for path, words in [
        (tmp_path / "none", "no such run folder"),
        (tmp_path, "holds no run"),
        (tmp_path / "file", "cannot be used as a run folder"),
    ]:
        with pytest.raises(RunError, match=words):
            resume_toy(path)
    with pytest.raises((RunError, StorageError), match="choose another"):
        start(tmp_path / "file", record(), ToyFactory())
    assert contents(tmp_path) == {"file": b"x"}


def stopped_run(folder):
    calls = itertools.count()
    with pytest.raises(StoppedError):
        start(folder, record(), ToyFactory(), stopped=lambda: next(calls) > 12)
    return folder


@pytest.mark.parametrize(
    ("name", "old", "new", "words"),
    [
        ("0-run.toml", b"cgagen-run-1", b"cgagen-run-2", "'cgagen-run-2'.*'cgagen-run-1'"),
        ("0-run.toml", b"seed = 7", b"seed = 8", "other settings"),
        ("0-run.toml", b"seed = 7", b"seed = -8", "has been changed.*seed is -8"),
        ("0-run.toml", b"seed = 7", b"sede = 7", "has been changed"),
        ("0-run.toml", b"seed = 7", b"seed = = 7", "is not TOML"),
        ("0-run.toml", b"population = 16", b"population = true", "has been changed"),
        ("0-run.toml", b"population = 16", b"population = 'x'", "has been changed"),
        ("0-run.toml", b"[world.options]", b"[world.option]", "has been changed"),
        ("0-run.toml", b"[inputs]", b"[[inputs]]", "has been changed"),
        ("0-run.toml", b"\n", b"\r\n", "has been changed"),
        ("0-run.toml", b"format", b"\xff", "not UTF-8"),
        ("1-prey.toml", b"prey", b"pray", "1-prey.toml: is not the file that the run began with"),
        ("2-checkpoint.npz", b"PK", b"KP", "2-checkpoint.npz: is damaged"),
    ],
)
def test_edited_files_are_refused(tmp_path, name, old, new, words):
    path = stopped_run(tmp_path / "run") / name
    assert old in path.read_bytes()
    path.write_bytes(path.read_bytes().replace(old, new))
    with pytest.raises(RunError, match=words) as caught:
        resume_toy(tmp_path / "run")
    assert "\n" not in str(caught.value)
    assert str(tmp_path) in str(caught.value)


def test_a_missing_input_is_named(tmp_path):
    (stopped_run(tmp_path / "run") / "1-arena.toml").unlink()
    with pytest.raises(RunError, match=r"1-arena.toml: cannot be read"):
        resume_toy(tmp_path / "run")


def test_a_checkpoint_that_was_cut_short(unbroken, tmp_path):
    path = stopped_run(tmp_path / "run") / "2-checkpoint.npz"
    path.write_bytes(path.read_bytes()[:1000])
    with pytest.raises(RunError, match="delete it to resume the run from its first generation"):
        resume_toy(tmp_path / "run")
    path.unlink()
    resume_toy(tmp_path / "run")
    assert contents(tmp_path / "run") == unbroken[1]


def test_a_run_of_another_version_is_refused(tmp_path, monkeypatch):
    stopped_run(tmp_path / "run")
    monkeypatch.setattr("cgagen.run.trials.__version__", "9.9")
    with pytest.raises(RunError, match=r"begun by cgagen .* this is 9\.9"):
        resume_toy(tmp_path / "run")


def test_a_trial_folder_of_another_run_is_refused(tmp_path):
    folder = tmp_path / "run"
    calls = itertools.count()
    with pytest.raises(StoppedError):
        start(folder, record(trials=2), ToyFactory(), stopped=lambda: next(calls) > 12)
    files.write_text(folder / "trial-2/0-run.toml", record(seed=9, first_trial=2, trials=1).text)
    with pytest.raises(RunError, match="trial-2: belongs to a run with other settings"):
        resume_toy(folder)


# --- settings, progress, streams


def test_the_record_is_its_text(tmp_path):
    one = record(
        evolution=Settings(population=99, mutation_rate=0.003, elite=2),
        populations_at=(),
        seed=2**63 - 1,
        world=(("hold", True), ("light", "dark"), ("turn_deg", 0.1), ("walls", 3)),
    )
    run_folder.write_beginning(tmp_path, one)
    assert read_record(tmp_path) == one
    assert str(tmp_path) not in one.text


def test_every_setting_changes_the_digest():
    """What decides the files is in the record; what does not (workers) is no setting."""
    one = record()
    changes = {
        "evolution": Settings(population=16, mutation_rate=0.002),
        "generations": 36,
        "starts_per_generation": 11,
        "steps": 201,
        "fixed_starts": 101,
        "fixed_starts_seed": 1,
        "evaluate_every": 11,
        "populations_at": (1,),
        "seed": 8,
        "first_trial": 2,
        "trials": 2,
        "world": (("hold", False),),
    }
    assert set(changes) == set(RunSettings.__dataclass_fields__)
    digests = {record(**{name: value}).digest for name, value in changes.items()}
    for name in Inputs.__dataclass_fields__:
        digests.add(replace(one, inputs=replace(one.inputs, **{name: "changed"})).digest)
    assert len(digests | {one.digest}) == len(changes) + 6 + 1


@pytest.mark.parametrize(
    "change",
    [
        {"generations": 0},
        {"starts_per_generation": 0},
        {"fixed_starts": 0},
        {"evaluate_every": 0},
        {"seed": -1},
        {"seed": 2**64},
        {"trials": 0},
        {"first_trial": 0},
        {"populations_at": (0,)},
    ],
)
def test_settings_that_cannot_be_are_refused(change):
    with pytest.raises(ValueError, match=next(iter(change))):
        RunSettings(**change)


def test_only_genomes_can_be_run():
    with pytest.raises(ValueError, match="192"):
        RunSettings(evolution=Settings(bits=64))


def test_progress_is_told_after_each_generation(tmp_path):
    seen = []
    start(tmp_path / "run", record(), ToyFactory(), observe=seen.append)
    assert [progress.generation for progress in seen] == list(range(1, 36))
    assert seen[-1].seconds_left == 0
    assert all(progress.steps_per_second > 0 for progress in seen)
    assert all(progress.generations == 35 and progress.trial == 1 for progress in seen)


def test_a_checkpoint_is_written_by_time_too(tmp_path, monkeypatch):
    monkeypatch.setattr("cgagen.run.loop.SAVE_AFTER_S", 0.0)
    written = []

    def watch(progress):
        written.append((tmp_path / "run/2-checkpoint.npz").exists())

    start(tmp_path / "run", record(generations=3), ToyFactory(), observe=watch)
    assert written == [True, True, True]


def test_streams_are_pinned_and_apart():
    """Pinned: a change here changes every run that anybody has made."""
    assert stream(7, 1, 3, Purpose.STARTS).random() == PINNED
    raw = {
        stream(seed, trial, generation, purpose).bit_generator.random_raw()
        for seed in (0, 1, 2**64 - 1)
        for trial in (0, 1, 2**24 - 1)
        for generation in (0, 1, 2**32 - 1)
        for purpose in Purpose
    }
    assert len(raw) == 3 * 3 * 3 * len(Purpose)
    key = stream(5, 2, 3, Purpose.CHILDREN).bit_generator.state["state"]["key"].tolist()
    assert key == [5, (2 << 40) + (3 << 8) + 2]


PINNED = 0.327132577961611


@pytest.mark.parametrize(
    "numbers", [(-1, 0, 0), (2**64, 0, 0), (0, 2**24, 0), (0, 0, 2**32), (0, 0, -1)]
)
def test_a_number_that_does_not_fit_the_key_is_refused(numbers):
    with pytest.raises(ValueError, match="must be 0 to"):
        stream(*numbers, streams.Purpose.STARTS)


def test_the_world_is_closed_whatever_happens(tmp_path):
    closed = []

    class Closing(ToyWorld):
        def close(self):
            closed.append(True)

    class Failing(Closing):
        def evaluate(self, bits, starts):
            raise ZeroDivisionError

    start(tmp_path / "a", record(generations=1), lambda threads: Closing())
    with pytest.raises(ZeroDivisionError):
        start(tmp_path / "b", record(), lambda threads: Failing())
    assert closed == [True, True]


def test_one_trial_has_all_threads_and_one_of_several_has_one(tmp_path):
    threads = []

    def make(count):
        threads.append(count)
        return ToyWorld()

    start(tmp_path / "a", record(generations=1), make, workers=4)
    start(tmp_path / "b", record(generations=1, trials=2), make, workers=1)
    assert threads == [4, 1, 1]
