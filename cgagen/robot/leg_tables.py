"""The tables of a robot file that say how it walks."""

from cgagen.robot.table import LAST_PIN, Table
from cgagen.robot.values import LEGS, Gait, Pose, Servo, ServoSet, Step
from cgagen.words import COMMANDS, Role


def steps_of(tables: Table, role: Role) -> tuple[Step, ...]:
    """Return the eight movements, by command."""
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


def gait_of(table: Table) -> Gait:
    """Return the tripod gait."""
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


START_FRAMES = 8
"""Where a file of an earlier version says nothing of them."""


def servo_set_of(table: Table) -> ServoSet:
    """Return all twelve servos."""
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
        start_frames=(
            table.integer("start_frames", 1, 50) if table.offers("start_frames") else START_FRAMES
        ),
        servos=tuple(servos),
    )
    table.done()
    return servo_set
