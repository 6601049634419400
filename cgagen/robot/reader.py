"""TOML text -> `Robot` or `Arena`.

Ranges of single numbers are refused here; `checks` does what needs more than one of them.
"""

from dataclasses import replace
from pathlib import Path

from cgagen import inputs
from cgagen.errors import RobotError
from cgagen.files import digest
from cgagen.near import did_you_mean
from cgagen.robot.checks import check_robot
from cgagen.robot.leg_tables import gait_of, servo_set_of, steps_of
from cgagen.robot.sensor_tables import FARTHEST_IN, antennas_of, light_of, sonars_of
from cgagen.robot.table import LAST_PIN, Table
from cgagen.robot.values import (
    SONARS,
    Arena,
    CommandLink,
    Echo,
    LocomotionChip,
    MainChip,
    Policy,
    Reflex,
    Robot,
    SituationLimits,
    StepLine,
)
from cgagen.words import COMMANDS, Movement, Role

ROBOTS_FOLDER = Path(__file__).parent.parent / "robots"

LEAST_GAP_MS = 25
"""From one sonar's trigger to the next. Ref: choice; a PING))) listens for 20 ms, and so long its
burst may come back from somewhere to another sonar."""

LONGEST_ECHO_MS = 20
"""What a rest stood behind, at most, in robot files of earlier versions."""

MODELS = ("BS2", "BS2e", "BS2sx", "BS2p", "BS2pe")


def shipped(format_name: str) -> list[str]:
    """Return the names of the robots ("robot") or arenas ("arena") that ship with cgagen.

    >>> shipped("robot")
    ['servobot-predator', 'servobot-prey']
    """
    mark = f'format = "cgagen-{format_name}-1"'
    return sorted(
        path.stem for path in ROBOTS_FOLDER.glob("*.toml") if mark in path.read_text("utf-8")
    )


def load_robot(name_or_path: str, *, role: Role | None = None) -> Robot:
    """Load a robot that ships with cgagen, by name, or any file.

    Args:
        name_or_path: "servobot-predator", or a path to a TOML file.
        role: refuse a robot of the other role.

    Raises:
        RobotError: no such robot, or its file says something that cannot be.

    >>> load_robot("servobot-predator").situation_counts.front_near
    1966
    """
    name, text = _open(name_or_path, "robot")
    robot = parse_robot(text, name)
    if role is not None and robot.role is not role:
        raise RobotError(f"{name}: role: a {robot.role}, where a {role} is wanted; choose another")
    return robot


def load_arena(name_or_path: str) -> Arena:
    """Load an arena likewise.

    Raises:
        RobotError: no such arena, or its file says something that cannot be.

    >>> load_arena("colony").side_units
    300.0
    """
    name, text = _open(name_or_path, "arena")
    return parse_arena(text, name)


def _open(name_or_path: str, what: str) -> tuple[str, str]:
    known = shipped(what)
    path = ROBOTS_FOLDER / f"{name_or_path}.toml" if name_or_path in known else Path(name_or_path)
    kind = replace(
        {"robot": inputs.ROBOT, "arena": inputs.ARENA}[what],
        mend=f"give a file, or one of {', '.join(known)}",
    )
    content = inputs.read_bytes_if_there(path, kind)
    if content is None:
        meant = did_you_mean(name_or_path, known)
        raise inputs.refused(name_or_path, kind, f"no such {what}{meant}")
    return path.name, inputs.decoded(content, path, kind)


def parse_arena(text: str, file: str) -> Arena:
    """Turn the text of an arena file into an `Arena`; `file` names it in errors."""
    top = Table.parse(file, text)
    top.text("format", ("cgagen-arena-1",))
    arena = Arena(
        name=top.label("name"),
        side_units=top.number("side_units", 50, 10_000),
        units_per_in=top.number("units_per_in", 0.01, 1000),
        longest_units=top.number("longest_units", 50, 20_000),
        capture_score_units=top.number("capture_score_units", 0, 20_000),
        start_gap_units=top.number("start_gap_units", 0, 10_000),
        walls=top.text("walls", ("slide", "stop")),
        after_capture=top.text("after_capture", ("hold", "go_on")),
        text=text,
        digest=digest(text),
    )
    if not arena.capture_score_units < arena.longest_units:
        raise top.error(
            "capture_score_units",
            f"{arena.capture_score_units:g} is out of reach; "
            f"less than longest_units = {arena.longest_units:g} is allowed",
        )
    if arena.start_gap_units > arena.side_units / 2:
        raise top.error("start_gap_units", "too wide to find two starts; at most half of a side")
    top.done()
    return arena


def parse_robot(text: str, file: str) -> Robot:
    """Turn the text of a robot file into a `Robot`; `file` names it in errors."""
    top = Table.parse(file, text)
    top.text("format", ("cgagen-robot-1",))
    role = Role(top.text("role", tuple(Role)))
    predator = role is Role.PREDATOR
    robot = Robot(
        name=top.label("name"),
        role=role,
        telemetry=top.flag("telemetry"),
        main=_main(top.table("main")),
        locomotion=_locomotion(top.table("locomotion")),
        body_radius_units=_single(top.table("body"), "radius_units", 0.1, 1000),
        echo=_echo(top.table("echo")),
        sonars=sonars_of(top, role),
        antennas=antennas_of(top),
        light=light_of(top.table("light")) if predator else None,
        limits=_limits(top.table("situation")) if predator else None,
        reflex=None if predator else _reflex(top.table("reflex")),
        link=_link(top.table("command")),
        steps=steps_of(top.table("movement"), role),
        gait=gait_of(top.table("gait")),
        servo_set=servo_set_of(top.table("servo")),
        text=text,
        digest=digest(text),
    )
    top.done()
    check_robot(robot, file)
    return robot


def _single(table: Table, key: str, low: float, high: float) -> float:
    value = table.number(key, low, high)
    table.done()
    return value


def _main(table: Table) -> MainChip:
    chip = MainChip(
        model=table.text("model", MODELS),
        pulsin_unit_ns=table.integer("pulsin_unit_ns", 100, 10_000),
        rctime_unit_ns=table.integer("rctime_unit_ns", 100, 10_000),
        pulsout_unit_ns=table.integer("pulsout_unit_ns", 100, 10_000),
    )
    table.done()
    return chip


def _locomotion(table: Table) -> LocomotionChip:
    chip = LocomotionChip(
        model=table.text("model", MODELS),
        pulsout_unit_ns=table.integer("pulsout_unit_ns", 100, 10_000),
    )
    table.done()
    return chip


def _echo(table: Table) -> Echo:
    """Return how sonars are asked; `rest_ms` is an earlier version's, a rest behind an echo."""
    if table.offers("rest_ms") and not table.has("trigger_gap_ms"):
        rest_ms = table.integer("rest_ms", 1, 1000 - LONGEST_ECHO_MS)
        gap_ms = max(LEAST_GAP_MS, rest_ms + LONGEST_ECHO_MS)
    else:
        gap_ms = table.integer("trigger_gap_ms", LEAST_GAP_MS, 1000)
    echo = Echo(
        us_per_in=table.number("us_per_in", 60, 90),
        trigger_us=table.number("trigger_us", 2, 100),
        trigger_gap_ms=gap_ms,
    )
    table.done()
    return echo


def _limits(table: Table) -> SituationLimits:
    def inches(key: str) -> float:
        return table.number(key, 0.5, FARTHEST_IN)

    limits = SituationLimits(
        masking=table.flag("masking"),
        front_near_in=inches("front_near_in"),
        front_middle_in=inches("front_middle_in"),
        front_far_in=inches("front_far_in"),
        side_near_in=inches("side_near_in"),
        side_far_in=inches("side_far_in"),
        target_front_near_in=inches("target_front_near_in"),
        target_front_middle_in=inches("target_front_middle_in"),
        target_side_near_in=inches("target_side_near_in"),
    )
    table.done()
    return limits


def _movement(table: Table, key: str) -> Movement:
    return Movement(table.text(key, tuple(COMMANDS[Role.PREY])))


def _reflex(table: Table) -> Reflex:
    tables = table.table("policies")
    policies = {}
    for name in tables.keys():
        policy = tables.table(tables.checked_label(name, name))
        policies[name] = Policy(
            alarm_in=policy.number("alarm_in", 0.5, FARTHEST_IN),
            answers=tuple(_movement(policy, sonar) for sonar in SONARS[Role.PREY]),
        )
        policy.done()
    if not policies:
        raise table.error("policies", f"none; wanted [{tables.path}.NAME] for each policy")
    reflex = Reflex(
        policy_name=table.text("policy", tuple(policies)),
        policies=policies,
        antenna_left=_movement(table, "antenna_left"),
        antenna_right=_movement(table, "antenna_right"),
        both_left_open=_movement(table, "both_left_open"),
        both_right_open=_movement(table, "both_right_open"),
    )
    table.done()
    return reflex


def _link(table: Table) -> CommandLink:
    step_line = None
    if not (table.has("step_line") and table.take("step_line", "") == "none"):
        line = table.table("step_line")
        step_line = StepLine(
            main_pin=line.integer("main_pin", 0, LAST_PIN),
            locomotion_pin=line.integer("locomotion_pin", 0, LAST_PIN),
        )
        line.done()
    link = CommandLink(
        main_pins=table.integers("main_pins", 3, 0, LAST_PIN),
        locomotion_pins=table.integers("locomotion_pins", 3, 0, LAST_PIN),
        step_line=step_line,
    )
    table.done()
    return link
