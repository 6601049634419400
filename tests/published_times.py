"""Published times of a BS2, each with a program that the emulator times as they were timed.

`python -m tests.published_times` shows them beside the emulator's, and the least-squares fit of
what `cgagen.emulator.timing` has for every instruction. Nothing here comes from the emulator but
what it is asked to run: the numbers are those of the sources.
"""

import sys
from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from cgagen.emulator.parts.probe import Probe
from cgagen.emulator.timing import US, timing_of
from cgagen.stamp.chips import chip
from cgagen.tokenizer import Tokenizer
from tests.chip_programs import chip_of

PARAMETERS = ("fetch_ns", "bit_ns", "jump_ns", "pause_setup_ns")
"""What is fitted; everything else in the programs below are units of instructions."""
PASSES = 30_000


class Published(NamedTuple):
    """One time that somebody has published.

    Attributes:
        name: in words.
        source: the program; what is timed is seen on pin 2, or on 13 where there is one.
        what: "width" of the pulse, or "period" of the pulses, on that pin.
        less_us: what the published number leaves out, of that,
        less_low: and whether it leaves out a LOW besides.
        us: the published number.
        ref: where, by the keys of SOURCES.md.
        times: what is timed happens so often within it.
    """

    name: str
    source: str
    what: str
    less_us: float
    less_low: bool
    us: float
    ref: str
    times: int = 1


PUBLISHED = (
    Published("HIGH or LOW", "HIGH 2\nLOW 2", "width", 0, False, 140, "S7"),
    Published("GOTO", "HIGH 2\nGOTO there\nthere:\nLOW 2", "width", 0, True, 290, "S7"),
    Published(
        "FOR of a word, PULSOUT of 1, NEXT: a pass",
        "w VAR Word\nFOR w = 1 TO 1000\nPULSOUT 2, 1\nNEXT", "period", 0, False, 1_000,
        "S10 (93973), logic analyser",
    ),
    Published(
        "FOR, two PULSOUTs, PAUSE 20, NEXT: all but pulses and pause",
        "w VAR Word\nFOR w = 1 TO 100\nPULSOUT 13, 850\nPULSOUT 12, 650\nPAUSE 20\nNEXT", "period",
        23_000, False, 1_600, "S24 p. 79, 89",
    ),
    Published(
        "HIGH, PAUSE 40, LOW: what the pulse is longer than 40 ms",
        "HIGH 2\nPAUSE 40\nLOW 2", "width", 40_000, False, 375, "S10 (138270), from S7's table",
    ),
    Published(
        "PULSOUT with a variable, up to its pulse",
        "t VAR Byte\nt = 100\nLOW 1\nHIGH 2\nPULSOUT 1, t\nLOW 2", "width", 200, True, 230,
        "S10 (138270), from S7's table",
    ),
    Published(
        "FOR of a word, NEXT: a pass",
        f"w VAR Word\nHIGH 2\nFOR w = 1 TO {PASSES}\nNEXT\nLOW 2", "width", 0, False, 733,
        "S28: 22 s, over 700 times a Javelin's 1 us, so 30,000 passes", PASSES,
    ),
)  # fmt: skip
"""Of a BS2."""

PUBLISHED_BS2E = (PUBLISHED[0]._replace(us=145), PUBLISHED[1]._replace(us=285))
"""Of a BS2e; nothing is fitted to them. Ref: S7, its follow-up."""


def emulated_us(
    tokenizer: Tokenizer,
    row: Published,
    model: str = "BS2",
    changes: Mapping[str, int] | None = None,
) -> float:
    """Return what the emulator takes, timed as the published number was."""
    timing = replace(timing_of(chip(model)), **(changes or {}))
    made = chip_of(tokenizer, f"{row.source}\nSTOP", model=model, timing=timing)
    probe = Probe("probe", made.clock, made.pins.wires[13 if "13" in row.source else 2])
    made.run(60_000_000_000)
    pulses = probe.pulses()
    width = row.what == "width"
    ns = pulses[0].width_ns if width else pulses[11].start_ns - pulses[10].start_ns
    low_us = emulated_us(tokenizer, PUBLISHED[0], model, changes) if row.less_low else 0
    return (ns / US - row.less_us - low_us) / row.times


def design(tokenizer: Tokenizer) -> tuple[np.ndarray, np.ndarray]:
    """Return how often each parameter counts in each row, and what counts besides, in us."""
    some = dict.fromkeys(PARAMETERS, 10 * US)
    counts, rests = [], []
    for row in PUBLISHED:
        us = emulated_us(tokenizer, row, changes=some)
        more = [emulated_us(tokenizer, row, changes=some | {one: 20 * US}) for one in PARAMETERS]
        counts.append([(one - us) / 10 for one in more])
        rests.append(us - 10 * sum(counts[-1]))
    return np.array(counts), np.array(rests)


def fitted_us(tokenizer: Tokenizer) -> dict[str, float]:
    """Return the parameters that make the sum of squared relative errors least."""
    counts, rest = design(tokenizer)
    wanted = np.array([row.us for row in PUBLISHED])
    found, *_ = np.linalg.lstsq(counts / wanted[:, None], (wanted - rest) / wanted, rcond=None)
    return dict(zip(PARAMETERS, (float(one) for one in found), strict=True))


def main() -> None:
    """Show both."""
    lines = []
    with Tokenizer() as tokenizer:
        for model, rows in (("BS2", PUBLISHED), ("BS2e", PUBLISHED_BS2E)):
            for row in rows:
                ours = emulated_us(tokenizer, row, model)
                off = 100 * (ours / row.us - 1)
                lines.append(f"{model:5} {row.us:7.0f} {ours:8.1f} {off:+6.1f} %  {row.name}")
        lines += [f"{name:15} {us:8.2f} us" for name, us in fitted_us(tokenizer).items()]
    sys.stdout.write("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
