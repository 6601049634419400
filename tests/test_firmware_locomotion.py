"""The locomotion controllers: the gait that is in the image, walked."""

import re
import tomllib
from itertools import pairwise

import pytest

from tests.firmware_cases import (
    CASES,
    LEGS,
    code,
    labels,
    source,
    split_frames,
    toy,
)
from tests.toy_pbasic import SilenceError


def wanted_frames(text: str, movement: str) -> list[tuple[dict[str, float], int]]:
    """The phases of a movement: pulse in counts by leg and joint, and its frames; from the file."""
    data = tomllib.loads(text)
    move, gait, servo = data["movement"][movement], data["gait"], data["servo"]
    order = [0, 1, 2, 3, 4, 5]
    first = move["first_phase"] - 1
    walk = order[first:] + order[:first]
    if move["order"] == "reverse":
        walk = [walk[4], walk[3], walk[2], walk[1], walk[0], walk[5]]
    frames = [gait["lift_frames"], move["push_frames"], gait["lower_frames"]] * 2
    phases = []
    for row, count in zip(walk, frames, strict=True):
        pulses = {}
        for index, leg in enumerate(LEGS):
            swing = move["left_deg" if leg[0] == "L" else "right_deg"]
            forward = gait["phase"][row]["forward"][index] == "1"
            up = gait["phase"][row]["up"][index] == "1"
            angles = (swing if forward else -swing, gait["lift_deg"] if up else 0)
            for joint, angle in enumerate(angles):
                trim, way = (servo[key][leg][joint] for key in ("trim_counts", "direction"))
                offset = way * angle * servo["counts_per_deg"]
                name = f"Pin{('Swing', 'Lift')[joint]}{leg}"
                pulses[name] = servo["centre_counts"] + trim + offset
        phases.append((pulses, count))
    return phases


@pytest.mark.parametrize(
    "case",
    ["predator", "predator-trimmed", "predator-bs2sx", "predator-other-pins", "prey"],
)
def test_every_movement_is_walked_as_the_file_has_it(case: str) -> None:
    text, program = CASES[case], toy(case, "locomotion")
    data = tomllib.loads(text)
    step = program.get("PulseStep")
    low, high = data["servo"]["min_counts"], data["servo"]["max_counts"]
    for command, movement in enumerate(data["movement"]):
        if data["movement"][movement]["order"] == "hold":
            continue
        program.frames.clear()
        program.set("command", command)
        program.run("Move")
        frames = split_frames(program.frames)
        for pulses, count in wanted_frames(text, movement):
            for _ in range(count):
                frame = frames.pop(0)
                assert frame.keys() == pulses.keys()
                for servo, wanted in pulses.items():
                    assert low <= frame[servo] <= high
                    assert abs(frame[servo] - wanted) <= step / 2, (movement, servo)
        assert not frames


def test_waiting_holds_the_last_pose() -> None:
    program = toy("prey", "locomotion")
    program.set("command", 2)
    program.run("Move")
    last = program.frames[-1]
    program.frames.clear()
    program.set("command", 1)
    program.run("Move")
    assert program.frames == [last] * 32


def test_it_stands_before_it_does_anything_else() -> None:
    program = toy("predator-trimmed", "locomotion")
    with pytest.raises(SilenceError):
        program.run("Start")
    program.frames = program.frames[-1:]
    trims = tomllib.loads(CASES["predator-trimmed"])["servo"]["trim_counts"]
    for leg in LEGS:
        for joint, name in enumerate(("Swing", "Lift")):
            assert abs(program.frames[0][f"Pin{name}{leg}"] - 750 - trims[leg][joint]) <= 2
    start = [line.strip() for line in code("predator", "locomotion").split("Start:")[1].split("\n")]
    assert start[1] == "DIRS = %0000111111111111"
    assert [line.partition(" ")[0] for line in start[2:4]] == ["READ", "READ"]
    text = code("predator", "locomotion")
    assert text.count("INPUT StepLine") == text.count("LOW StepLine") == 1
    assert text.index("GOSUB SayWho") < text.index("INPUT StepLine") < text.index("LOW StepLine")


def test_legs_start_one_after_another_and_are_centred_so() -> None:
    """At first one leg has pulses, then two: the last of the list first, for the frames that the
    file says. On a bench all have pulses, and one after another changes.
    """
    program = toy("predator-trimmed", "locomotion")
    pulses: list[str] = []
    program.pulse = lambda pin, width: pulses.append(pin)
    with pytest.raises(SilenceError):
        program.run("Start")
    del program.pulse
    for behind, (first, then) in enumerate(pairwise(LEGS[::-1]), 1):
        begun = pulses.index(f"PinSwing{then}")
        assert pulses[:begun].count(f"PinSwing{first}") == 8
        assert len(set(pulses[:begun])) == 2 * behind
    program.set("command", 3)
    program.run("Move")
    program.inbox, program.frames = ["?C00"], []
    with pytest.raises(SilenceError):
        program.run("BenchNext")
    frames = split_frames(program.frames)
    legs = [
        {servo[-2:] for servo in now if now[servo] != before[servo]}
        for before, now in pairwise(frames)
    ]
    assert [leg for leg in legs if leg] == [{leg} for leg in LEGS]
    trims = tomllib.loads(CASES["predator-trimmed"])["servo"]["trim_counts"]
    for leg in LEGS:
        for joint, name in enumerate(("Swing", "Lift")):
            assert abs(frames[-1][f"Pin{name}{leg}"] - 750 - trims[leg][joint]) <= 2
    changes = [n for n, leg in enumerate(legs) if leg]
    assert all(then - now == 8 for now, then in pairwise(changes))


def test_equal_swings_share_one_table() -> None:
    text = source("predator", "locomotion")
    assert re.findall(r"^(Swing[A-Z]) ", text, re.M) == [f"Swing{letter}" for letter in "ABCDE"]
    assert labels("predator", "locomotion")["SwingE"] <= 255
