"""The reference images, byte by byte, against the genome and the robots' files.

Nothing is executed here: what the programs read from their EEPROM is read in the same way.
"""

import hashlib
import json
import re
from pathlib import Path

import pytest

from cgagen import genome
from cgagen.robot import load_robot
from cgagen.robot.gait import PHASES, phases_of, pulses_counts

pytestmark = pytest.mark.hil_req("IMAGES")

FIRMWARE = Path(__file__).parent.parent / "firmware"
ROBOTS = {"predator": "servobot-predator", "prey": "servobot-prey"}
PULSE_STEP_COUNTS = 4
"""What one step of a pulse byte stands for; the programs multiply by it."""


def labels(role: str, program: str) -> dict[str, int]:
    """Return the EEPROM address of each DATA label, from the memory report."""
    report = (FIRMWARE / role / "memory.txt").read_text("utf-8")
    part = report[report.index(program) :].split("DATA by label", 1)[1].split("\n\n", 1)[0]
    rows = re.findall(r"^ +(\w+) +\d+ +(\d+) +\d+$", part, re.M)
    return {name: int(address) for name, address in rows}


def image(role: str, program: str) -> bytes:
    return (FIRMWARE / role / f"{program}.bin").read_bytes()


@pytest.mark.parametrize("role", ROBOTS)
@pytest.mark.parametrize("program", ["main", "locomotion"])
def test_images_are_the_recorded_ones(role: str, program: str) -> None:
    record = json.loads((FIRMWARE / role / "build.json").read_text("utf-8"))["programs"][program]
    eeprom = image(role, program)
    assert len(eeprom) == 2048
    assert hashlib.sha256(eeprom).hexdigest() == record["image_digest"]
    assert any(eeprom[-32:]), "an empty slot"


def test_the_image_holds_the_genome() -> None:
    wanted = genome.load(FIRMWARE / "reference.genome").commands()
    at = labels("predator", "main.bsp")["Genes"]
    assert tuple(image("predator", "main")[at : at + 64]) == wanted
    assert len(set(wanted)) == 8


@pytest.mark.parametrize("role", ROBOTS)
def test_the_image_holds_the_gait(role: str) -> None:
    """Walk every movement through the tables as the program does; compare each pulse."""
    robot, eeprom = load_robot(ROBOTS[role]), image(role, "locomotion")
    at = labels(role, "locomotion.bs2")
    order = robot.servo_set.servos
    pulses = 0
    for command, step in enumerate(robot.steps):
        row = at["Moves"] + 4 * command
        table, pose, turn, push = eeprom[row : row + 4]
        if step.order == "hold":
            assert turn == 0
            continue
        for phase in phases_of(robot, step):
            assert pose == phase.pose
            swings = eeprom[table + 6 * pose : table + 6 * pose + 6]
            lifts = eeprom[at["Lifts"] + 6 * pose : at["Lifts"] + 6 * pose + 6]
            wanted = pulses_counts(robot, step, robot.gait.poses[pose])
            for index, (servo, width) in enumerate(zip(order, wanted, strict=True)):
                byte = (lifts if servo.joint == "vertical" else swings)[index // 2]
                assert abs(byte * PULSE_STEP_COUNTS - width) <= PULSE_STEP_COUNTS / 2
                pulses += 1
            pose = (pose + turn) % PHASES
        assert push == step.frames
    assert pulses >= 7 * PHASES * 12


@pytest.mark.parametrize("role", ROBOTS)
def test_every_threshold_is_in_the_source(role: str) -> None:
    robot = load_robot(ROBOTS[role])
    source = (FIRMWARE / role / "main.bsp").read_text("ascii")
    constants = set(map(int, re.findall(r"^\w+ +CON +(\d+) ", source, re.M)))
    found = robot.situation_counts if robot.limits else (robot.alarm_count,)
    counts = {one for each in found for one in (each if isinstance(each, tuple) else (each,))}
    assert len(counts) >= (7 if robot.limits else 1)  # both light sensors ship with one curve
    assert counts <= constants
