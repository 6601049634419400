"""`bench.toml`: the robot as a bench of the emulator, both Stamps with all that is wired to them.

What the sensors see at the beginning is nothing: no target, no touch, no light.
"""

from collections.abc import Iterator

from cgagen.firmware import LOCOMOTION_FILE, MAIN_FILE
from cgagen.robot.values import Robot, Servo, Sonar

BENCH_FORMAT = "cgagen-bench-1"


def bench_text(robot: Robot) -> str:
    """Return the bench of a robot as TOML; the same robot gives the same bytes."""
    main = {
        "pulsin_ns": robot.main.pulsin_unit_ns,
        "rctime_ns": robot.main.rctime_unit_ns,
        "pulsout_ns": robot.main.pulsout_unit_ns,
    }
    locomotion = {"pulsout_ns": robot.locomotion.pulsout_unit_ns}
    blocks = [
        [
            "# Both Stamps of the robot and what is wired to them, for the emulator.",
            "",
            f'format = "{BENCH_FORMAT}"',
        ],
        *_chip("main", robot.main.model, MAIN_FILE, main),
        *_chip("locomotion", robot.locomotion.model, LOCOMOTION_FILE, locomotion),
        *_link(robot),
    ]
    for sonar in robot.sonars:
        blocks += _sonar(robot, sonar)
    names = ", ".join(f'"sonar_{sonar.name}"' for sonar in robot.sonars)
    blocks += _part("air", "air", {}, [f"sonars = [{names}]"])
    for antenna in robot.antennas:
        blocks += _part(f"antenna_{antenna.name}", "whisker", {"signal": f"main.P{antenna.pin}"})
    if robot.light:
        capacitor = [f"capacitor_uf = {robot.light.capacitor_uf!r}"]
        for sensor in robot.light.sensors:
            pins = {"signal": f"main.P{sensor.pin}"}
            blocks += _part(f"light_{sensor.name}", "photocell", pins, capacitor)
    for servo in robot.servo_set.servos:
        blocks += _servo(robot, servo)
    return "\n\n".join("\n".join(block) for block in blocks) + "\n"


def _chip(name: str, model: str, source: str, units: dict[str, int]) -> Iterator[list[str]]:
    image = source.rpartition(".")[0] + ".bin"
    yield [
        f"[chip.{name}]",
        f'model = "{model}"',
        f'image = "{image}"',
        f'source = "{source}"',
    ]
    yield [f"[chip.{name}.timing]", *(f"{key} = {value}" for key, value in units.items())]


def _link(robot: Robot) -> Iterator[list[str]]:
    pairs = zip(robot.link.main_pins, robot.link.locomotion_pins, strict=True)
    for bit, (main, locomotion) in enumerate(pairs):
        yield _wire(f"command_{bit}", [f"main.P{main}", f"locomotion.P{locomotion}"], "down")
    line = robot.link.step_line
    if line:
        yield _wire("step", [f"main.P{line.main_pin}", f"locomotion.P{line.locomotion_pin}"], "up")


def _sonar(robot: Robot, sonar: Sonar) -> Iterator[list[str]]:
    leads = ("signal",) if len(sonar.pins) == 1 else ("trigger", "echo")
    pins = {lead: f"main.P{pin}" for lead, pin in zip(leads, sonar.pins, strict=True)}
    grounded = ["mode_grounded = true"] if robot.grounds_mode(sonar) else None
    return _part(f"sonar_{sonar.name}", sonar.kind, pins, grounded)


def _servo(robot: Robot, servo: Servo) -> Iterator[list[str]]:
    """A positive angle swings forward or lifts, on either side."""
    unit_us = robot.locomotion.pulsout_unit_ns / 1_000
    settings = [
        f"centre_us = {(robot.servo_set.centre_counts + servo.trim_counts) * unit_us!r}",
        f"us_per_deg = {robot.servo_set.counts_per_deg * unit_us!r}",
    ]
    if servo.direction < 0:
        settings.append("mirrored = true")
    name = f"servo_{servo.leg}_{servo.joint}"
    return _part(name, "servo", {"signal": f"locomotion.P{servo.pin}"}, settings)


def _part(
    name: str, kind: str, pins: dict[str, str], settings: list[str] | None = None
) -> Iterator[list[str]]:
    """A part, and a wire from each of its leads to a pin."""
    yield [f"[part.{name}]", f'kind = "{kind}"', *(settings or [])]
    for lead, pin in pins.items():
        wire = name if len(pins) == 1 else f"{name}_{lead}"
        yield _wire(wire, [pin, f"{name}.{lead}"])


def _wire(name: str, ends: list[str], pull: str | None = None) -> list[str]:
    lines = [f"[wire.{name}]", "ends = [" + ", ".join(f'"{end}"' for end in ends) + "]"]
    return lines if pull is None else [*lines, f'pull = "{pull}"']
