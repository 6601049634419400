"""TOML text -> `Robot` or `Arena`.

Ranges of single numbers are refused here; `checks` does what needs more than one of them.
"""

from pathlib import Path

from cgagen.counts import CURVE_SEGMENTS
from cgagen.errors import RobotError
from cgagen.files import digest
from cgagen.robot.checks import check_robot
from cgagen.robot.table import Table
from cgagen.robot.values import (
    LEGS,
    SIDES,
    SONAR_KINDS,
    SONARS,
    Antenna,
    Arena,
    CommandLink,
    Echo,
    Gait,
    Light,
    LightSensor,
    LocomotionChip,
    MainChip,
    Policy,
    Pose,
    Reflex,
    Robot,
    Servo,
    ServoSet,
    SituationLimits,
    Sonar,
    Step,
    StepLine,
)
from cgagen.words import COMMANDS, Movement, Role

ROBOTS_FOLDER = Path(__file__).parent.parent / "robots"

MODELS = ("BS2", "BS2e", "BS2sx", "BS2p", "BS2pe")
LAST_PIN = 15
FARTHEST_IN = 300.0
"""More than any sonar of the two kinds can see, twice over."""


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
    1843
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
    try:
        return path.name, path.read_bytes().decode("utf-8")
    except OSError as error:
        raise RobotError(
            f"{name_or_path}: no such {what} ({error.strerror}); "
            f"give a file, or one of {', '.join(known)}"
        ) from error
    except UnicodeDecodeError as error:
        raise RobotError(f"{name_or_path}: not UTF-8 at byte {error.start}; save it so") from error


def parse_arena(text: str, file: str) -> Arena:
    """Turn the text of an arena file into an `Arena`; `file` names it in errors."""
    top = Table.parse(file, text)
    top.text("format", ("cgagen-arena-1",))
    arena = Arena(
        name=top.text("name"),
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
        name=top.text("name"),
        role=role,
        telemetry=top.flag("telemetry"),
        main=_main(top.table("main")),
        locomotion=_locomotion(top.table("locomotion")),
        body_radius_units=_single(top.table("body"), "radius_units", 0.1, 1000),
        echo=_echo(top.table("echo")),
        sonars=_sonars(top, role),
        antennas=_antennas(top),
        light=_light(top.table("light")) if predator else None,
        limits=_limits(top.table("situation")) if predator else None,
        reflex=None if predator else _reflex(top.table("reflex")),
        link=_link(top.table("command")),
        steps=_steps(top.table("movement"), role),
        gait=_gait(top.table("gait")),
        servo_set=_servo_set(top.table("servo")),
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
    echo = Echo(
        us_per_in=table.number("us_per_in", 60, 90),
        trigger_us=table.number("trigger_us", 2, 100),
        rest_ms=table.integer("rest_ms", 1, 100),
    )
    table.done()
    return echo


def _in_order(
    tables: list[Table], names: tuple[str, ...], top: Table, key: str
) -> list[tuple[str, Table]]:
    """Return the tables in the order of the names; each name once, and no other."""
    found: dict[str, Table] = {}
    for table in tables:
        name = table.text("name", names)
        if name in found:
            raise table.error("name", f"{name!r} stands twice; each of {', '.join(names)} once")
        found[name] = table
    for name in names:
        if name not in found:
            raise top.error(key, f"{name!r} is missing; wanted {', '.join(names)}")
    return [(name, found[name]) for name in names]


def _sonars(top: Table, role: Role) -> tuple[Sonar, ...]:
    sonars = []
    for name, table in _in_order(top.tables("sonar"), SONARS[role], top, "sonar"):
        kind = table.text("kind", tuple(SONAR_KINDS))
        sonars.append(
            Sonar(
                name=name,
                kind=kind,
                bearing_deg=table.number("bearing_deg", -360, 360),
                cone_deg=table.number("cone_deg", 1, 170),
                range_in=table.number("range_in", 1, FARTHEST_IN),
                pins=tuple(table.integer(key, 0, LAST_PIN) for key in SONAR_KINDS[kind].pins),
            )
        )
        table.done()
    return tuple(sonars)


def _antennas(top: Table) -> tuple[Antenna, ...]:
    antennas = []
    for name, table in _in_order(top.tables("antenna"), SIDES, top, "antenna"):
        antennas.append(
            Antenna(
                name=name,
                bearing_deg=table.number("bearing_deg", -360, 360),
                length_in=table.number("length_in", 0.1, FARTHEST_IN),
                robot_deg=table.pair("robot_deg", -180, 180),
                pin=table.integer("pin", 0, LAST_PIN),
            )
        )
        table.done()
    return tuple(antennas)


def _light(table: Table) -> Light:
    sensors = []
    for name, one in _in_order(table.tables("sensor"), SIDES, table, "sensor"):
        sensors.append(
            LightSensor(
                name=name,
                bearing_deg=one.number("bearing_deg", -360, 360),
                cone_deg=one.number("cone_deg", 1, 170),
                pin=one.integer("pin", 0, LAST_PIN),
            )
        )
        one.done()
    light = Light(
        condition=table.text("condition", ("dark", "ambient")),
        dark_range_in=table.number("dark_range_in", 1, FARTHEST_IN),
        ambient_range_in=table.number("ambient_range_in", 1, FARTHEST_IN),
        capacitor_uf=table.number("capacitor_uf", 0.0001, 10),
        charge_ms=table.integer("charge_ms", 1, 1000),
        curve=_curve(table),
        sensors=tuple(sensors),
    )
    table.done()
    return light


def _curve(table: Table) -> tuple[tuple[float, int], ...]:
    wanted = f"2 to {CURVE_SEGMENTS + 1} pairs [inches, count 1 to 65535], both rising"
    value = table.take("curve", wanted)
    rows = value if isinstance(value, list) else []
    points: list[tuple[float, int]] = []
    for row in rows:
        match row:
            case [int() | float() as inches, int() as count] if (
                not isinstance(inches, bool)
                and not isinstance(count, bool)
                and 0 <= inches <= FARTHEST_IN
                and 1 <= count <= 65_535
                and (not points or (inches > points[-1][0] and count > points[-1][1]))
            ):
                points.append((float(inches), count))
            case _:
                raise table.error("curve", f"{row!r} does not fit; wanted {wanted}")
    if not 2 <= len(points) <= CURVE_SEGMENTS + 1:
        raise table.error("curve", f"{len(points)} pairs; wanted {wanted}")
    return tuple(points)


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
        policy = tables.table(name)
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


def _steps(tables: Table, role: Role) -> tuple[Step, ...]:
    steps = []
    for movement in COMMANDS[role]:
        table = tables.table(movement)
        order = table.text("order", ("forward", "reverse", "hold"))
        hold = order == "hold"
        steps.append(
            Step(
                movement=movement,
                along_units=table.number("along_units", -100, 100),
                right_units=table.number("right_units", -100, 100),
                turn_deg=table.number("turn_deg", -360, 360),
                order=order,
                first_phase=0 if hold else table.integer("first_phase", 1, 6),
                left_deg=0.0 if hold else table.number("left_deg", -60, 60),
                right_deg=0.0 if hold else table.number("right_deg", -60, 60),
                frames=table.integer("hold_frames" if hold else "push_frames", 1, 200),
            )
        )
        table.done()
    tables.done()
    return tuple(steps)


def _mask(table: Table, key: str) -> tuple[bool, ...]:
    value = table.text(key)
    if len(value) != len(LEGS) or set(value) - {"0", "1"}:
        raise table.error(key, f"{value!r} is not six of 0 and 1, in the order {' '.join(LEGS)}")
    return tuple(digit == "1" for digit in value)


def _gait(table: Table) -> Gait:
    legs = table.take("legs", f"the legs in the order {' '.join(LEGS)}")
    if legs != list(LEGS):
        raise table.error("legs", f"{legs!r}; the order {' '.join(LEGS)} is wanted")
    tables = table.tables("phase")
    if len(tables) != 6:
        raise table.error("phase", f"{len(tables)} poses; six are wanted")
    poses = []
    for one in tables:
        poses.append(Pose(up=_mask(one, "up"), forward=_mask(one, "forward")))
        one.done()
    gait = Gait(
        lift_deg=table.number("lift_deg", 1, 60),
        lift_frames=table.integer("lift_frames", 1, 100),
        lower_frames=table.integer("lower_frames", 1, 100),
        poses=tuple(poses),
    )
    table.done()
    return gait


def _servo_set(table: Table) -> ServoSet:
    pins, directions, trims = (table.table(key) for key in ("pin", "direction", "trim_counts"))
    servos = []
    for leg in LEGS:
        rows = zip(
            ("horizontal", "vertical"),
            pins.integers(leg, 2, 0, LAST_PIN),
            directions.integers(leg, 2, -1, 1),
            trims.integers(leg, 2, -250, 250),
            strict=True,
        )
        for joint, pin, direction, trim in rows:
            if direction == 0:
                raise directions.error(leg, "0 is no direction; 1 or -1 is allowed")
            servos.append(Servo(leg, joint, pin, direction, trim))
    for part in (pins, directions, trims):
        part.done()
    servo_set = ServoSet(
        centre_counts=table.integer("centre_counts", 1, 5000),
        counts_per_deg=table.number("counts_per_deg", 0.1, 100),
        min_counts=table.integer("min_counts", 1, 5000),
        max_counts=table.integer("max_counts", 1, 5000),
        servos=tuple(servos),
    )
    table.done()
    return servo_set
