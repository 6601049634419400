"""From a tape measure to a robot file: displacements of movements, counts of sensors.

`measurements` reads what was typed or recorded, `displacements` and `sensors` turn it into
means and say what is odd about them, `edit` puts the means into the text of a robot file, and
`effect` says what that does to a genome.
"""

from cgagen.calibrate.calibration import Calibration, calibrate
from cgagen.calibrate.effect import Effect, effect_of
from cgagen.calibrate.measurements import HEADERS, Measurements, read_measurements

__all__ = [
    "HEADERS",
    "Calibration",
    "Effect",
    "Measurements",
    "calibrate",
    "effect_of",
    "read_measurements",
]
