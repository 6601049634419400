"""Robot and arena files with anything wrong: they are values or sentences."""

import copy
from collections.abc import Callable
from typing import Any

import pytest
import tomli_w
from hypothesis import given, settings
from hypothesis import strategies as st

from cgagen.errors import RobotError
from cgagen.robot import Arena, Robot, load_robot
from cgagen.robot.reader import parse_arena, parse_robot
from tests.pursuit import content
from tests.robot_changes import PREDATOR, PREY, Content, put


def places(data: Any, path: tuple[str | int, ...] = ()) -> list[tuple[str | int, ...]]:
    """Return the paths of all values of a file, tables and lists among them."""
    inner = data.items() if isinstance(data, dict) else enumerate(data)
    found = []
    for key, value in inner:
        found.append((*path, key))
        if isinstance(value, dict | list):
            found += places(value, (*path, key))
    return found


GARBAGE = st.one_of(
    st.booleans(),
    st.integers(-(2**63), 2**63 - 1),
    st.integers(-20, 20),
    st.floats(),
    st.floats(-400, 400),
    st.text("ab01é \"'\\\n[", max_size=7),
    st.sampled_from(["none", "hold", "FORWARD", "ping", "srf04", "left"]),
    st.lists(st.one_of(st.integers(-5, 20), st.floats(), st.lists(st.integers(), max_size=2))),
    st.dictionaries(st.sampled_from(["name", "pin", "x"]), st.integers(0, 20), max_size=2),
)


def refusal_of(parse: Callable[[str, str], object], text: str) -> str | None:
    """Return the sentence with which a text is refused, or None; other errors are bugs."""
    try:
        parse(text, "mine.toml")
    except RobotError as error:
        return str(error)
    return None


def garbled(data: Content, changes: list[tuple[int, Any]]) -> str:
    changed = copy.deepcopy(data)
    paths = places(data)
    for number, value in changes:
        try:
            put(*paths[number % len(paths)], to=value)(changed)
        except (KeyError, IndexError, TypeError):
            continue  # an earlier change took that place away
    return tomli_w.dumps(changed)


CHANGES = st.lists(st.tuples(st.integers(0, 500), GARBAGE), min_size=1, max_size=3)


@given(st.sampled_from([PREDATOR, PREY]), CHANGES)
@settings(max_examples=400, deadline=None)
def test_garbage_is_a_robot_or_a_sentence(data: Content, changes: list[tuple[int, Any]]) -> None:
    text = garbled(data, changes)
    sentence = refusal_of(parse_robot, text)
    if sentence is None:
        robot = parse_robot(text, "mine.toml")
        assert isinstance(robot, Robot)
        assert robot.interface
        assert robot.alarm_count if robot.reflex else robot.situation_counts
    else:
        assert sentence.startswith("mine.toml: ")
        assert "\n" not in sentence


@given(CHANGES)
@settings(max_examples=60, deadline=None)
def test_garbage_is_an_arena_or_a_sentence(changes: list[tuple[int, Any]]) -> None:
    text = garbled(content("colony"), changes)
    sentence = refusal_of(parse_arena, text)
    if sentence is None:
        assert isinstance(parse_arena(text, "mine.toml"), Arena)
    else:
        assert sentence.startswith("mine.toml: ")
        assert "\n" not in sentence


@given(st.binary(max_size=60))
@settings(max_examples=60, deadline=None)
def test_noise_is_refused(tmp_path_factory: pytest.TempPathFactory, data: bytes) -> None:
    path = tmp_path_factory.getbasetemp() / "noise.toml"
    path.write_bytes(data)
    with pytest.raises(RobotError):
        load_robot(str(path))
