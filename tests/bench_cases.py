"""The benches of both robots, as built, and what their controllers say."""

import re
from pathlib import Path

from cgagen.build.bench import bench_text
from cgagen.emulator.bench import Bench
from cgagen.emulator.bench_file import parse_bench
from cgagen.robot import load_robot

FIRMWARE = Path(__file__).parent.parent / "firmware"
MS = 1_000_000
S = 1_000_000_000
STARTS = 3
"""Seconds more than a decision takes, in which the legs rise and a host may say hello."""


def robot_bench(role: str, faults: str = "") -> Bench:
    """The checked-in programs of a robot, with a host on each Stamp and a target in front."""
    text = bench_text(load_robot(f"servobot-{role}")) + faults
    bench = parse_bench(text, "bench.toml", FIRMWARE / role)
    for chip in bench.chips:
        bench.host(chip)
    return bench


def decisions(bench: Bench) -> list[dict[str, int]]:
    """The telemetry of the main controller: `:0 F7374 R9218 ... S7 C6` is one decision."""
    text = bench.host("main").received.decode("latin-1")
    lines = [line for line in text.split("\r") if line.startswith(":")]
    return [
        {name: int(value) for name, value in re.findall(r"([A-Z]+)(\d+)", line)} for line in lines
    ]
