"""A run: the loop over generations, its seeds, and the folder that holds all of it.

The world is an argument (`World`), so this room knows no robot and no simulator. `start` begins a
run in a new folder, `resume` continues one after any interruption, bit for bit.
"""

from cgagen.run.folder import read_record
from cgagen.run.loop import Observer, Progress, Scores, World, WorldFactory
from cgagen.run.record import Inputs, Option, RunRecord, RunSettings
from cgagen.run.stop import stop_on_signals
from cgagen.run.trials import Outcome, TrialOutcome, resume, start

__all__ = [
    "Inputs",
    "Observer",
    "Option",
    "Outcome",
    "Progress",
    "RunRecord",
    "RunSettings",
    "Scores",
    "TrialOutcome",
    "World",
    "WorldFactory",
    "read_record",
    "resume",
    "start",
    "stop_on_signals",
]
