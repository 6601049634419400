"""Robots that a lab might make of the two that ship, and the programs that are built for them."""

import random
import re
from functools import cache

from cgagen.build import Build, make_build
from cgagen.genome import Genome
from cgagen.memory import report
from cgagen.robot import ROBOTS_FOLDER, Robot
from cgagen.robot.reader import parse_robot
from cgagen.tokenizer import Tokenizer
from tests.toy_pbasic import Toy

_DIGITS = random.Random(20)
GENOME = Genome("".join(_DIGITS.choice("01") for _ in range(192)))

PREDATOR = (ROBOTS_FOLDER / "servobot-predator.toml").read_text("utf-8")
PREY = (ROBOTS_FOLDER / "servobot-prey.toml").read_text("utf-8")

STEP_LINE = re.search(r"^step_line = .*$", PREDATOR, re.MULTILINE)[0]


def changed(text: str, *pairs: tuple[str, str]) -> str:
    """Return the text with each pair's first occurrence replaced; all of them must occur."""
    for old, new in pairs:
        assert old in text, old
        text = text.replace(old, new, 1)
    return text


def with_model(text: str, chip: str, model: str, unit_ns: int, rctime_ns: int = 0) -> str:
    """Return the text with another model as one chip, and its units."""
    head, section, rest = text.partition(f"[{chip}]")
    rest = re.sub(r'^model = ".*?"', f'model = "{model}"', rest, count=1, flags=re.MULTILINE)
    for key, value in (("pulsin", unit_ns), ("rctime", rctime_ns or unit_ns), ("pulsout", unit_ns)):
        if chip == "main" or key == "pulsout":
            pattern = rf"^{key}_unit_ns = \d+"
            rest = re.sub(pattern, f"{key}_unit_ns = {value}", rest, count=1, flags=re.MULTILINE)
    return head + section + rest


def fine_servos(text: str) -> str:
    """Return the text with servo counts of 0.8 us instead of 2 us."""
    return changed(
        text,
        ("centre_counts = 750", "centre_counts = 1875"),
        ("counts_per_deg = 5 ", "counts_per_deg = 12.5 "),
        ("min_counts = 500", "min_counts = 1250"),
        ("max_counts = 1000", "max_counts = 2500"),
    )


def srf04(text: str, pins: dict[int, tuple[int, int]]) -> str:
    """Return the text with SRF04s in place of PING)))s, trigger and echo by the old pin."""
    text = text.replace('kind = "ping"', 'kind = "srf04"')
    for pin, (trigger, echo) in pins.items():
        line = re.search(rf"^pin = {pin} .*$", text, re.MULTILINE)[0]
        text = text.replace(line, f"trigger_pin = {trigger}\necho_pin = {echo}", 1)
    return text


PREDATOR_SRF04 = srf04(PREDATOR, {4: (4, 5), 5: (6, 7), 6: (12, 13)})

RIGHT_CURVE = """[
    [2, 20], [6, 90], [12, 230], [20, 480], [30, 850], [40, 1250], [60, 2200], [84, 3500],
    [96, 4200],
]"""
"""Of a photoresistor that is a third slower than the left one."""


def two_curves(text: str) -> str:
    """Return the text with another curve for the right light sensor."""
    head, _, right = text.rpartition("curve = [")
    return head + "curve = " + RIGHT_CURVE + right[right.index("\n]") + 2 :]


CASES: dict[str, str] = {
    "predator-two-curves": two_curves(PREDATOR),
    "predator": PREDATOR,
    "predator-free-running": changed(PREDATOR, (STEP_LINE, 'step_line = "none"')),
    "predator-silent": changed(PREDATOR, ("telemetry = true", "telemetry = false")),
    "predator-unmasked": changed(PREDATOR, ("masking = true", "masking = false")),
    "predator-ambient": changed(PREDATOR, ('condition = "dark"', 'condition = "ambient"')),
    "predator-srf04": PREDATOR_SRF04,
    "predator-srf04-bs2": with_model(PREDATOR_SRF04, "main", "BS2", 2000),
    "predator-other-pins": changed(
        PREDATOR,
        ("main_pins = [0, 1, 2]", "main_pins = [12, 13, 14]"),
        ("main_pin = 3,", "main_pin = 0,"),
        ("pin = 8 ", "pin = 15 "),
        ("locomotion_pins = [12, 13, 14]", "locomotion_pins = [4, 5, 6]"),
        ("locomotion_pin = 15", "locomotion_pin = 12"),
        ("LR = [4, 5]", "LR = [13, 14]"),
        ("RF = [6, 7]", "RF = [15, 7]"),
    ),
    "predator-trimmed": changed(
        PREDATOR, ("LF = [0, 0]", "LF = [13, -7]"), ("RM = [0, 0]", "RM = [-21, 2]")
    ),
    "predator-bs2e": with_model(
        with_model(PREDATOR, "main", "BS2e", 2000), "locomotion", "BS2e", 2000
    ),
    "predator-bs2sx": fine_servos(
        with_model(with_model(PREDATOR, "main", "BS2sx", 800), "locomotion", "BS2sx", 800)
    ),
    "predator-bs2pe": with_model(
        with_model(PREDATOR, "main", "BS2pe", 2000), "locomotion", "BS2pe", 2000
    ),
    "predator-bs2p-legs": fine_servos(with_model(PREDATOR, "locomotion", "BS2p", 800)),
    "prey": PREY,
    "prey-wall": changed(PREY, ('policy = "turn"', 'policy = "wall"')),
    "prey-wary": changed(PREY, ('policy = "turn"', 'policy = "wary"')),
    "prey-free-running": changed(PREY, (STEP_LINE, 'step_line = "none"')),
    "prey-free-silent": changed(
        PREY, (STEP_LINE, 'step_line = "none"'), ("telemetry = true", "telemetry = false")
    ),
    "prey-silent": changed(PREY, ("telemetry = true", "telemetry = false")),
    "prey-bs2": with_model(PREY, "main", "BS2", 2000),
}


def robot_of(case: str) -> Robot:
    """Return the robot of a case."""
    return parse_robot(CASES[case], f"{case}.toml")


def genome_of(case: str) -> Genome | None:
    """Return the genome that the case's robot is built with."""
    return GENOME if case.startswith("predator") else None


PREDATORS = [case for case in CASES if case.startswith("predator")]
PREYS = [case for case in CASES if case.startswith("prey")]
TOKENIZER = Tokenizer()
LEGS = ("LF", "LM", "LR", "RF", "RM", "RR")


@cache
def built(case: str) -> Build:
    return make_build(robot_of(case), genome_of(case), TOKENIZER)


def source(case: str, chip: str) -> str:
    return built(case).programs[chip == "locomotion"].program.source


def code(case: str, chip: str) -> str:
    """The source without comments and texts."""
    return re.sub(r"\"[^\"\n]*\"|'[^\n]*", "", source(case, chip))


@cache
def labels(case: str, chip: str) -> dict[str, int]:
    text = source(case, chip)
    data = report(TOKENIZER.compile(text, chip)).data
    assert data is not None
    return {block.name: block.address for block in data}


def eeprom(case: str, chip: str) -> bytes:
    return built(case).programs[chip == "locomotion"].image.eeprom


def toy(case: str, chip: str) -> Toy:
    return Toy(source(case, chip), eeprom(case, chip), labels(case, chip))


def split_frames(frames: list[dict[str, int]]) -> list[dict[str, int]]:
    """The toy begins a frame at pin 0; with other pins the pulses come as one long list."""
    flat = [item for frame in frames for item in frame.items()]
    return [dict(flat[start : start + 12]) for start in range(0, len(flat), 12)]
