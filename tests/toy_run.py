"""A world for tests of the run: individuals that count their ones. Also a program to be killed."""

import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cgagen import __version__
from cgagen.errors import CgagenError
from cgagen.evolve import Settings
from cgagen.run import Inputs, RunRecord, RunSettings, resume, start, stop_on_signals

INPUTS = Inputs("predator\n", "prey\n", "arena\n", "servobot-predator", "sonar a, light b", "ab12")


@dataclass(frozen=True)
class ToyScores:
    fitness: np.ndarray
    captured: np.ndarray


class ToyWorld:
    """Fitness: ones, and twice the one that each start points at. Exact in binary."""

    def __init__(self, pause_s=0.0):
        self.pause_s = pause_s

    def draw_starts(self, rng, count):
        return rng.random((count, 8))

    def evaluate(self, bits, starts):
        time.sleep(self.pause_s)
        pointed = bits[:, (starts[:, 0] * bits.shape[1]).astype(int)]
        fitness = bits.sum(axis=1) + 2.0 * pointed.sum(axis=1) / 64
        return ToyScores(fitness.astype(np.float64), pointed.sum(axis=1) / 128.0)

    def close(self):
        pass


@dataclass(frozen=True)
class ToyFactory:
    pause_s: float = 0.0

    def __call__(self, threads):
        return ToyWorld(self.pause_s)


@dataclass(frozen=True)
class FatalFactory:
    """A world that kills its own process, as the out-of-memory killer would."""

    def __call__(self, threads):
        import os
        import signal

        os.kill(os.getpid(), signal.SIGKILL)


@dataclass(frozen=True)
class BuggyFactory:
    def __call__(self, threads):
        raise ZeroDivisionError("a planted bug")


def record(**changes):
    evolution = Settings(population=16, mutation_rate=0.001)
    values = {"evolution": evolution, "generations": 35, "populations_at": (1, 15), "seed": 7}
    return RunRecord(RunSettings(**(values | changes)), INPUTS, (("cgagen", __version__),))


def main(verb, folder, pause_s, trials, workers):
    try:
        with stop_on_signals() as stopped:
            factory = ToyFactory(float(pause_s))
            options = {"workers": int(workers), "stopped": stopped}
            sys.stdout.write("ready\n")
            sys.stdout.flush()
            if verb == "start":
                start(Path(folder), record(trials=int(trials)), factory, **options)
            else:
                resume(Path(folder), lambda record: factory, **options)
    except CgagenError as error:
        sys.stderr.write(f"{error}\n")
        return error.exit_code
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
