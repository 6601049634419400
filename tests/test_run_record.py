"""Settings and their digest, progress, random streams, and the world that a run opens."""

from dataclasses import replace

import pytest

from cgagen.evolve import Settings
from cgagen.run import Inputs, RunSettings, read_record, start, streams
from cgagen.run import folder as run_folder
from cgagen.run.streams import Purpose, stream
from tests.toy_run import ToyFactory, ToyWorld, record


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
