"""What the main controllers must decide, from a robot's file and the paper, by other code."""

import itertools
import math
import tomllib


def counts_of(text: str) -> dict[str, int]:
    """The thresholds of a robot file as counts, by the formulas alone."""
    data = tomllib.loads(text)
    per_in = 2 * data["echo"]["us_per_in"] * 1000 / data["main"]["pulsin_unit_ns"]
    limits = data["situation"]

    def light(side: int, inches: float) -> int:
        rows = data["light"]["sensor"][side]["curve"]
        for (near, less), (far, more) in itertools.pairwise(rows):
            if near <= inches <= far:
                return math.floor(less + (more - less) * (inches - near) / (far - near) + 1e-9)
        raise AssertionError(inches)

    return {
        "EchoFrontNear": math.floor(limits["front_near_in"] * per_in),
        "EchoFrontMiddle": math.floor(limits["front_middle_in"] * per_in),
        "EchoFrontFar": math.floor(limits["front_far_in"] * per_in),
        "EchoSideNear": math.floor(limits["side_near_in"] * per_in),
        "EchoSideFar": math.floor(limits["side_far_in"] * per_in),
    } | {
        f"{word}Lamp{name}": light(side, inches)
        for side, word in enumerate(("Left", "Right"))
        for name, inches in (
            ("Near", limits["target_front_near_in"]),
            ("Middle", limits["target_front_middle_in"]),
            ("Side", limits["target_side_near_in"]),
            ("Range", data["light"][data["light"]["condition"] + "_range_in"]),
        )
    }


NO, NEAR_RIGHT, FAR_RIGHT, NEAR_LEFT, FAR_LEFT, NEAR_FRONT, MIDDLE_FRONT, FAR_FRONT = range(8)


def predator_state(
    limits: dict[str, int],
    masking: bool,
    sonars: tuple[int, ...],
    light: tuple[int, int],
    touched: tuple[bool, bool],
) -> int:
    """The state as the paper and the robot's file have it, written for this test."""
    sides = list(zip(("Left", "Right"), light, strict=True))
    lit_left, lit_right = (1 <= count < limits[f"{side}LampRange"] for side, count in sides)
    if lit_left and lit_right:
        target = FAR_FRONT
        for name, nearer in (("Middle", MIDDLE_FRONT), ("Near", NEAR_FRONT)):
            if any(count < limits[f"{side}Lamp{name}"] for side, count in sides):
                target = nearer
        hidden = {"front", "right", "left"}
    elif lit_right:
        target = NEAR_RIGHT if light[1] < limits["RightLampSide"] else FAR_RIGHT
        hidden = {"front", "right"}
    elif lit_left:
        target = NEAR_LEFT if light[0] < limits["LeftLampSide"] else FAR_LEFT
        hidden = {"front", "left"}
    else:
        target, hidden = NO, set()
    seen = {
        name: 65535 if count == 0 or (masking and name in hidden) else count
        for name, count in zip(("front", "right", "left"), sonars, strict=True)
    }
    nearest = min(seen, key=lambda name: seen[name])  # the first of equals
    count = seen[nearest]
    if all(touched):
        obstacle = NEAR_FRONT
    elif touched[0]:
        obstacle = NEAR_LEFT
    elif touched[1]:
        obstacle = NEAR_RIGHT
    elif nearest == "front":
        obstacle = (
            NEAR_FRONT
            if count < limits["EchoFrontNear"]
            else MIDDLE_FRONT
            if count < limits["EchoFrontMiddle"]
            else FAR_FRONT
            if count < limits["EchoFrontFar"]
            else NO
        )
    else:
        near, far = (NEAR_RIGHT, FAR_RIGHT) if nearest == "right" else (NEAR_LEFT, FAR_LEFT)
        obstacle = (
            near if count < limits["EchoSideNear"] else far if count < limits["EchoSideFar"] else NO
        )
    return 8 * obstacle + target


def edges(*limits: int) -> list[int]:
    near = [limit + offset for limit in limits for offset in (-1, 0, 1)]
    return [0, 1, *near, 23125, 65534, 65535]


def prey_answer(text: str, sonars: tuple[int, ...], touched: tuple[bool, bool]) -> tuple[int, str]:
    """State and movement of the prey, written for this test."""
    data = tomllib.loads(text)
    reflex = data["reflex"]
    policy = reflex["policies"][reflex["policy"]]
    names = ("front_left", "front_right", "left", "right", "rear_left", "rear_right")
    seen = {name: count or 65535 for name, count in zip(names, sonars, strict=True)}
    if all(touched):
        side = "both_left_open" if seen["left"] > seen["right"] else "both_right_open"
        return (9 if side == "both_left_open" else 10), reflex[side]
    if touched[0]:
        return 7, reflex["antenna_left"]
    if touched[1]:
        return 8, reflex["antenna_right"]
    nearest = min(names, key=lambda name: seen[name])
    if seen[nearest] < prey_alarm(text):
        return 1 + names.index(nearest), policy[nearest]
    return 0, "WAIT"


def prey_alarm(text: str) -> int:
    data = tomllib.loads(text)
    per_in = 2 * data["echo"]["us_per_in"] * 1000 / data["main"]["pulsin_unit_ns"]
    return math.floor(data["reflex"]["policies"][data["reflex"]["policy"]]["alarm_in"] * per_in)
