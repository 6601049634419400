"""Robots, genomes and starts that several tests of the world share."""

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w
from numpy.typing import NDArray

from cgagen.robot import Arena, Robot, load_arena, load_robot
from cgagen.robot.reader import ROBOTS_FOLDER, parse_arena, parse_robot
from cgagen.words import GENES, GENOME_BITS
from sim.numbers import Options
from tests.oracle import Oracle, Pose

Bits = NDArray[np.uint8]


def shipped() -> tuple[Robot, Robot, Arena]:
    """Return the predator, the prey and the arena that ship."""
    return load_robot("servobot-predator"), load_robot("servobot-prey"), load_arena("colony")


def content(name: str) -> dict[str, Any]:
    """Return a shipped file as nested dictionaries, to be changed."""
    return tomllib.loads(Path(ROBOTS_FOLDER, f"{name}.toml").read_text("utf-8"))


def robot_from(changed: dict[str, Any]) -> Robot:
    """Return the robot of a changed file."""
    return parse_robot(tomli_w.dumps(changed), "changed.toml")


def arena_from(changed: dict[str, Any]) -> Arena:
    """Return the arena of a changed file."""
    return parse_arena(tomli_w.dumps(changed), "changed.toml")


def oracle_of(predator: Robot, prey: Robot, arena: Arena, options: Options | None = None) -> Oracle:
    """Return the oracle of a world and its options."""
    options = options or Options()
    assert predator.light is not None
    assert predator.limits is not None
    assert prey.reflex is not None
    light, masking = predator.light, options.masking
    dark = (options.light or light.condition) == "dark"
    return Oracle(
        predator,
        prey,
        arena,
        hold=(options.after_capture or arena.after_capture) == "hold",
        masking=predator.limits.masking if masking is None else masking,
        light_range_in=light.dark_range_in if dark else light.ambient_range_in,
        policy=options.prey_policy or prey.reflex.policy_name,
        stop_at_walls=(options.walls or arena.walls) == "stop",
    )


def random_bits(rng: np.random.Generator, count: int) -> Bits:
    """Return random genomes, shape (count, 192)."""
    return rng.integers(0, 2, (count, GENOME_BITS), dtype=np.uint8)


def hunter_bits(rng: np.random.Generator, count: int, changed: float = 0.05) -> Bits:
    """Return genomes that chase what they see, with a share of their bits inverted.

    Random genomes hardly ever come near the prey; these make captures.
    """
    # no; right near, far; left near, far; front near, middle, far
    to_target = (0, 2, 2, 3, 3, 0, 0, 0)
    from_obstacle = (0, 3, 3, 2, 2, 5, 5, 3)
    genes = [
        to_target[state % 8] if state % 8 else from_obstacle[state // 8] for state in range(GENES)
    ]
    row = np.array([gene >> bit & 1 for gene in genes for bit in (2, 1, 0)], np.uint8)
    return np.asarray(row ^ (rng.random((count, GENOME_BITS)) < changed), np.uint8)


def genes_of(row: Bits) -> list[int]:
    """Return the 64 commands of one genome, by hand."""
    bits = row.tolist()
    return [4 * bits[3 * n] + 2 * bits[3 * n + 1] + bits[3 * n + 2] for n in range(GENES)]


def poses_of(start: NDArray[np.float64]) -> tuple[Pose, Pose]:
    """Return a start's eight columns as two poses in degrees."""
    px, py, pc, ps, qx, qy, qc, qs = start.tolist()
    return (
        Pose(px, py, float(np.degrees(np.arctan2(ps, pc)))),
        Pose(qx, qy, float(np.degrees(np.arctan2(qs, qc)))),
    )


def other_world() -> tuple[Robot, Robot, Arena]:
    """Return a world in which nearly every number differs from the shipped one."""
    return _other_predator(), _other_prey(), _other_arena()


def _other_predator() -> Robot:
    changed = content("servobot-predator")
    changed["main"] |= {"pulsin_unit_ns": 2000, "model": "BS2"}
    changed["echo"]["us_per_in"] = 71.3
    changed["body"]["radius_units"] = 7.25
    front, right, left = changed["sonar"]
    front |= {"bearing_deg": 4, "cone_deg": 50, "kind": "srf04", "echo_pin": 12, "trigger_pin": 13}
    del front["pin"]
    right |= {"bearing_deg": -41.5, "cone_deg": 76, "range_in": 40}
    left |= {"bearing_deg": 47, "cone_deg": 33}
    touch_left, touch_right = changed["antenna"]
    touch_left |= {"bearing_deg": 31, "length_in": 12, "robot_deg": [-20, 61]}
    touch_right |= {"bearing_deg": 340, "length_in": 7.5, "robot_deg": [-90, -2]}
    changed["light"] |= {"dark_range_in": 61, "ambient_range_in": 22.5}
    lit_left, lit_right = changed["light"]["sensor"]
    lit_left["curve"] = [[3, 9], [15.5, 260], [33, 800], [75, 2222]]
    lit_right["curve"] = [[2, 20], [14, 410], [35, 1300], [80, 3050], [99, 3600]]
    lit_left |= {"bearing_deg": 19, "cone_deg": 71}
    lit_right |= {"bearing_deg": 329, "cone_deg": 80.5}
    changed["situation"] |= {
        "front_near_in": 7.3,
        "front_middle_in": 15,
        "front_far_in": 44,
        "side_near_in": 13.9,
        "side_far_in": 28,
        "target_front_near_in": 14,
        "target_front_middle_in": 37,
        "target_side_near_in": 25.5,
    }
    changed["movement"]["FORWARD"] |= {"along_units": 6.1, "right_units": -0.7, "turn_deg": 2.2}
    changed["movement"]["LEFT_FORWARD"] |= {"along_units": 3.3, "turn_deg": 29.3}
    changed["movement"]["BACKUP_LEFT"] |= {"right_units": -1.9, "turn_deg": -31}
    return robot_from(changed)


def _other_prey() -> Robot:
    changed = content("servobot-prey")
    changed["main"]["pulsin_unit_ns"] = 800
    changed["echo"]["us_per_in"] = 75.25
    changed["body"]["radius_units"] = 9.5
    for sonar, bearing_deg, cone_deg, range_in in zip(
        changed["sonar"],
        (22, 341, 80, 262.5, 139, -135),
        (41, 62, 55, 71, 80, 100),
        (40, 150, 40, 35, 150, 20),
        strict=True,
    ):
        sonar |= {"bearing_deg": bearing_deg, "cone_deg": cone_deg, "range_in": range_in}
    rear = changed["sonar"][4]
    rear |= {"kind": "srf04", "echo_pin": 12, "trigger_pin": 13}
    del rear["pin"]
    touch_left, touch_right = changed["antenna"]
    touch_left |= {"bearing_deg": 38, "length_in": 8.2, "robot_deg": [5, 95]}
    touch_right |= {"bearing_deg": 300, "length_in": 13, "robot_deg": [-50, 11]}
    changed["reflex"] |= {
        "antenna_left": "ROTATE_RIGHT",
        "antenna_right": "LEFT_FORWARD",
        "both_left_open": "BACKUP_LEFT",
        "both_right_open": "ROTATE_LEFT",
    }
    changed["reflex"]["policies"]["turn"] |= {"alarm_in": 27.7, "rear_left": "RIGHT_FORWARD"}
    changed["movement"]["WAIT"] |= {"along_units": 0.3, "turn_deg": 7.7}
    changed["movement"]["FORWARD"] |= {"along_units": 4.2, "right_units": 1.3}
    return robot_from(changed)


def _other_arena() -> Arena:
    changed = content("colony")
    return arena_from(
        changed
        | {
            "side_units": 231.5,
            "units_per_in": 2.6,
            "longest_units": 327.4,
            "capture_score_units": 309.9,
            "start_gap_units": 20,
        }
    )
