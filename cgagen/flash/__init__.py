"""Our own programmer for BASIC Stamps: from an image to a chip over a serial port.

The protocol is a generator over bytes (`identify`, `download`) that knows neither ports nor
clocks; `line` carries it out; `programmer` is the whole way with lock, diagnoses and report.
::

    from cgagen.build import read_image
    from cgagen.flash import flash_image

    report = flash_image("/dev/ttyUSB0", read_image(folder, "main"), verify=True)

Nothing in here has met a real Stamp: BENCH.md says what is to be tried first.
"""

from cgagen.flash.modules import Module
from cgagen.flash.plan import Plan, plan_of
from cgagen.flash.programmer import FlashReport, flash_image, identify_port
from cgagen.flash.requests import Progress

__all__ = [
    "FlashReport",
    "Module",
    "Plan",
    "Progress",
    "flash_image",
    "identify_port",
    "plan_of",
]
