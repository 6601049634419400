"""What hangs on which pin of both Stamps: for the sources' headers and for the wiring table."""

from dataclasses import dataclass

from cgagen.firmware.columns import camel
from cgagen.robot.values import Robot, Servo, Sonar


@dataclass(frozen=True, slots=True)
class PinUse:
    """One pin.

    Attributes:
        pin: 0 to 15.
        name: its PIN symbol in the source; "" where the pin is reached as part of a nibble.
        what: what hangs on it, for a comment.
        wiring: parts between the pin and that.
    """

    pin: int
    name: str
    what: str
    wiring: str


SERIES = "470 ohm in series"
"""Two outputs against each other stay below 11 mA. Choice; Ref: S9, 20 mA a pin of a BS2."""

ANTENNA = "220 ohm, 10 kohm to +5 V"
"""Ref: S5 and common practice for whiskers."""


def sonar_pin_names(sonar: Sonar) -> tuple[str, ...]:
    """Return the PIN symbols of a sonar, in the order of its pins."""
    name = camel(sonar.name)
    return (f"Sonar{name}",) if len(sonar.pins) == 1 else (f"Trigger{name}", f"Echo{name}")


def servo_pin_name(servo: Servo) -> str:
    """Return the PIN symbol of a servo."""
    return f"Pin{'Swing' if servo.joint == 'horizontal' else 'Lift'}{servo.leg}"


def main_pins(robot: Robot) -> tuple[PinUse, ...]:
    """Return what the main controller's pins are for, by pin."""
    uses = [
        PinUse(
            pin,
            "",
            f"command bit {bit}, to the locomotion controller's P{other}",
            SERIES,
        )
        for bit, (pin, other) in enumerate(
            zip(robot.link.main_pins, robot.link.locomotion_pins, strict=True)
        )
    ]
    line = robot.link.step_line
    if line:
        uses.append(
            PinUse(
                line.main_pin,
                "StepLine",
                f"step line, to the locomotion controller's P{line.locomotion_pin}",
                SERIES,
            )
        )
    for sonar in robot.sonars:
        kinds = ("SIG",) if len(sonar.pins) == 1 else ("trigger", "echo")
        part = "PING)))" if sonar.kind == "ping" else "SRF04"
        for pin, name, lead in zip(sonar.pins, sonar_pin_names(sonar), kinds, strict=True):
            what = f"{part} {sonar.name.replace('_', ' ')}, {lead}, {sonar.bearing_deg:g} deg"
            uses.append(PinUse(pin, name, what, "direct"))
    for antenna in robot.antennas:
        what = f"antenna {antenna.name}, 0 = touched, {antenna.bearing_deg:g} deg"
        uses.append(PinUse(antenna.pin, f"Antenna{camel(antenna.name)}", what, ANTENNA))
    if robot.light:
        parts = f"220 ohm, photoresistor || {robot.light.capacitor_uf:g} uF"
        for sensor in robot.light.sensors:
            what = f"light sensor {sensor.name}, {sensor.bearing_deg:g} deg"
            uses.append(PinUse(sensor.pin, f"Lamp{camel(sensor.name)}", what, parts))
    return tuple(sorted(uses, key=lambda use: use.pin))


def locomotion_pins(robot: Robot) -> tuple[PinUse, ...]:
    """Return what the locomotion controller's pins are for, by pin."""
    uses = []
    for servo in robot.servo_set.servos:
        turned = "" if servo.direction > 0 else ", mirrored"
        trim = f", trim {servo.trim_counts:+d} counts" if servo.trim_counts else ""
        what = f"servo {servo.leg} {servo.joint}{turned}{trim}"
        uses.append(PinUse(servo.pin, servo_pin_name(servo), what, "10 kohm to ground"))
    for bit, (pin, other) in enumerate(
        zip(robot.link.locomotion_pins, robot.link.main_pins, strict=True)
    ):
        what = f"command bit {bit}, from the main controller's P{other}"
        uses.append(PinUse(pin, "", what, "10 kohm to ground"))
    line = robot.link.step_line
    if line:
        what = f"step line, to the main controller's P{line.main_pin}"
        uses.append(PinUse(line.locomotion_pin, "StepLine", what, "10 kohm to +5 V"))
    return tuple(sorted(uses, key=lambda use: use.pin))


def pin_lines(uses: tuple[PinUse, ...]) -> list[str]:
    """Return the pin table of a source's header."""
    return [f"P{use.pin:<4}{use.what}" for use in uses]
