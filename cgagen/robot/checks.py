"""What needs more than one number of a robot file: pins, orders, cones, pulses, ranges."""

import itertools

from cgagen.counts import FARTHEST_COUNT
from cgagen.errors import RobotError
from cgagen.robot.gait import PHASES, phases_of, pulses_counts
from cgagen.robot.values import LAST_EARLY_PIN, LEGS, SLOW_MODELS, Robot


def check_robot(robot: Robot, file: str) -> None:
    """Refuse a robot whose parts do not fit together.

    Raises:
        RobotError: file, key and what is allowed.
    """
    for check in (
        _pins,
        _command_nibbles,
        _situations,
        _sides,
        _cones,
        _echoes,
        _light,
        _start_pose,
        _pulses,
    ):
        sentence = check(robot)
        if sentence:
            raise RobotError(f"{file}: {sentence}")


def _pins(robot: Robot) -> str | None:
    """Every pin has one user, on each chip."""
    main = [(f"[sonar.{sonar.name}] pin", pin) for sonar in robot.sonars for pin in sonar.pins]
    main += [(f"[antenna.{antenna.name}] pin", antenna.pin) for antenna in robot.antennas]
    sensors = robot.light.sensors if robot.light else ()
    main += [(f"[light.sensor.{sensor.name}] pin", sensor.pin) for sensor in sensors]
    main += [("[command] main_pins", pin) for pin in robot.link.main_pins]
    locomotion = [("[command] locomotion_pins", pin) for pin in robot.link.locomotion_pins]
    locomotion += [
        (f"[servo.pin] {servo.leg} {servo.joint}", servo.pin) for servo in robot.servo_set.servos
    ]
    if robot.link.step_line:
        main.append(("[command.step_line] main_pin", robot.link.step_line.main_pin))
        locomotion.append(
            ("[command.step_line] locomotion_pin", robot.link.step_line.locomotion_pin)
        )
    return _first_shared_pin(main, "main controller") or _first_shared_pin(
        locomotion, "locomotion controller"
    )


def _first_shared_pin(users: list[tuple[str, int]], chip: str) -> str | None:
    owner: dict[int, str] = {}
    for key, pin in users:
        if pin in owner:
            free = [str(spare) for spare in range(16) if spare not in {p for _, p in users}]
            return (
                f"{key}: P{pin} of the {chip} is already used by {owner[pin]}; "
                f"free pins: {', '.join(free) or 'none'}"
            )
        owner[pin] = key
    return None


def _command_nibbles(robot: Robot) -> str | None:
    """The lines are written and read as one nibble, so that no half-written code is on them."""
    for key, pins in (
        ("main_pins", robot.link.main_pins),
        ("locomotion_pins", robot.link.locomotion_pins),
    ):
        if pins[0] % 4 or pins != tuple(range(pins[0], pins[0] + 3)):
            return (
                f"[command] {key}: {list(pins)} is not the low three pins of a nibble; "
                "[0, 1, 2], [4, 5, 6], [8, 9, 10] or [12, 13, 14] is allowed"
            )
    fourth = robot.link.main_pins[0] + 3
    line = robot.link.step_line
    used = {pin for sonar in robot.sonars for pin in sonar.pins}
    used |= {sensor.pin for sensor in (robot.light.sensors if robot.light else ())}
    if fourth in used and not (line and line.main_pin == fourth):
        return (
            f"[command] main_pins: P{fourth}, the fourth pin of their nibble, would be written "
            "with them; keep it free, or give it the step line or an antenna"
        )
    return None


def _situations(robot: Robot) -> str | None:
    limits = robot.limits
    if limits is None:
        return None
    for rising in (
        ("front_near_in", "front_middle_in", "front_far_in"),
        ("side_near_in", "side_far_in"),
        ("target_front_near_in", "target_front_middle_in"),
    ):
        for less, more in itertools.pairwise(rising):
            if not getattr(limits, less) < getattr(limits, more):
                return (
                    f"[situation] {less}: {getattr(limits, less):g} is not less than "
                    f"{more} = {getattr(limits, more):g}; the limits must rise"
                )
    counts = robot.situation_counts
    for less, more in (
        ("front_near", "front_middle"),
        ("front_middle", "front_far"),
        ("side_near", "side_far"),
    ):
        if not getattr(counts, less) < getattr(counts, more):
            return (
                f"[situation] {less}_in: the same chip count as {more}_in, "
                f"{getattr(counts, more)}; move them apart"
            )
    for side, lamp in (("left", counts.lamp_left), ("right", counts.lamp_right)):
        if not lamp.front_near < lamp.front_middle:
            return (
                "[situation] target_front_near_in: the same chip count as target_front_middle_in "
                f"by the curve of the {side} light sensor, {lamp.front_middle}; move them apart"
            )
    return None


def _sides(robot: Robot) -> str | None:
    """What is called left looks left of the heading, and right right."""
    parts = [("sonar", sonar.name, sonar.bearing_deg) for sonar in robot.sonars]
    parts += [("antenna", antenna.name, antenna.bearing_deg) for antenna in robot.antennas]
    sensors = robot.light.sensors if robot.light else ()
    parts += [("light.sensor", sensor.name, sensor.bearing_deg) for sensor in sensors]
    for kind, name, bearing_deg in parts:
        bearing = bearing_deg % 360
        side = name.rsplit("_", maxsplit=1)[-1]
        if side == "left" and not 0 < bearing < 180:
            return f"[{kind}.{name}] bearing_deg: {bearing_deg:g} is not to the left; 0 to 180 is"
        if side == "right" and not 180 < bearing < 360:
            return (
                f"[{kind}.{name}] bearing_deg: {bearing_deg:g} is not to the right; 180 to 360 is"
            )
    return None


def _apart_deg(one_deg: float, other_deg: float) -> float:
    return abs((one_deg - other_deg + 180) % 360 - 180)


def _cones(robot: Robot) -> str | None:
    """A cone that lies within another tells nothing apart."""
    for inner in robot.sonars:
        for outer in robot.sonars:
            apart = _apart_deg(inner.bearing_deg, outer.bearing_deg)
            if inner is not outer and apart + inner.cone_deg / 2 <= outer.cone_deg / 2:
                return (
                    f"[sonar.{inner.name}] cone_deg: its cone lies within that of "
                    f"{outer.name!r}; turn it or narrow the other"
                )
    return None


def _echoes(robot: Robot) -> str | None:
    """The longest echo fits into the 16 bits of PULSIN. Ref: S2 p. 343."""
    for sonar in robot.sonars:
        longest = robot.echo_limits_counts(sonar)[1]
        if longest > FARTHEST_COUNT:
            return (
                f"[main] pulsin_unit_ns: the longest echo of the {sonar.name!r} sonar is "
                f"{longest:.0f} counts, and PULSIN ends at {FARTHEST_COUNT}; a longer unit is "
                "allowed"
            )
        early = robot.main.model not in SLOW_MODELS or sonar.pins[-1] <= LAST_EARLY_PIN
        if sonar.mode == "open" and not early:
            return (
                f"[sonar.{sonar.name}] echo_pin: a {robot.main.model} looks at "
                f"P{sonar.pins[-1]} when the echo of an SRF04 has begun; take one of P0 to "
                f'P{LAST_EARLY_PIN}, or ground its mode pin and say mode = "ground"'
            )
    return _silence(robot)


def _silence(robot: Robot) -> str | None:
    """What is heard of nothing is farther than every limit."""
    limits, reflex = robot.limits, robot.reflex
    keys = {}
    if limits is not None:
        keys["[situation] front_far_in"] = limits.front_far_in
        keys["[situation] side_far_in"] = limits.side_far_in
    if reflex is not None:
        for name, policy in reflex.policies.items():
            keys[f"[reflex.policies.{name}] alarm_in"] = policy.alarm_in
    nothing = min(robot.sonars, key=lambda sonar: robot.echo_limits_counts(sonar)[1])
    longest = int(robot.echo_limits_counts(nothing)[1])
    for key, inches in keys.items():
        if robot.echo_count_of(inches) > longest:
            most_in = longest / robot.echo_counts_per_in
            return (
                f"{key}: {inches:g} in is farther than the {nothing.name!r} sonar hears, so that "
                f"nothing would be an obstacle; {most_in:.0f} in at most"
            )
    return None


def _light(robot: Robot) -> str | None:
    light, limits = robot.light, robot.limits
    if light is None or limits is None:
        return None
    left, right = light.sensors
    if left.cone_deg / 2 <= _apart_deg(left.bearing_deg, 0) or right.cone_deg / 2 <= _apart_deg(
        right.bearing_deg, 0
    ):
        return (
            "[light.sensor.left] cone_deg: both sensors must see a lamp straight ahead; "
            "each cone must be wider than twice its bearing"
        )
    if _apart_deg(left.bearing_deg, right.bearing_deg) <= abs(left.cone_deg - right.cone_deg) / 2:
        return "[light.sensor.left] cone_deg: one cone lies within the other; turn them apart"
    needed = max(light.range_in, limits.target_front_middle_in, limits.target_side_near_in)
    counts = robot.situation_counts
    for sensor, lamp in zip(light.sensors, (counts.lamp_left, counts.lamp_right), strict=True):
        where = f"[light.sensor.{sensor.name}] curve"
        if needed > sensor.curve[-1][0]:
            return f"{where}: ends at {sensor.curve[-1][0]:g} in; it must reach {needed:g} in"
        if lamp.range < 2:
            return f"{where}: the count at the range must be at least 2, or nothing is ever lit"
    return None


def _start_pose(robot: Robot) -> str | None:
    """Every movement ends on six legs, the left front one forward. Ref: S1 II.A.

    A walk that ends with legs in the air would lift in the frames of a push.
    """
    for step in robot.steps:
        if step.order == "hold":
            continue
        last = robot.gait.poses[phases_of(robot, step)[-1].pose]
        left_front = LEGS.index("LF")
        ahead = step.left_deg == 0 or last.forward[left_front] == (step.left_deg > 0)
        if any(last.up) or not ahead:
            return (
                f"[movement.{step.movement}] first_phase: it does not end on six legs with the "
                f"left front leg forward; choose another phase of 1 to {PHASES}, or the other "
                "sign of left_deg"
            )
    return None


def _pulses(robot: Robot) -> str | None:
    """No pulse of any pose leaves the servos' limits."""
    servo_set = robot.servo_set
    if not servo_set.min_counts < servo_set.centre_counts < servo_set.max_counts:
        return "[servo] centre_counts: not between min_counts and max_counts"
    for step in robot.steps:
        if step.order == "hold":
            continue
        for pose in robot.gait.poses:
            widths = pulses_counts(robot, step, pose)
            for servo, width in zip(servo_set.servos, widths, strict=True):
                if not servo_set.min_counts <= width <= servo_set.max_counts:
                    return (
                        f"[movement.{step.movement}]: the {servo.joint} servo of {servo.leg} "
                        f"would get a pulse of {width:g} counts; {servo_set.min_counts} to "
                        f"{servo_set.max_counts} is allowed: swing, lift or trim less"
                    )
    return None
