"""`wiring.txt`: what to solder, pin by pin, for both Stamps."""

import textwrap

from cgagen.bench_protocol import plain
from cgagen.firmware.pins import PinUse, locomotion_pins, main_pins
from cgagen.robot.values import SLOW_MODELS, Robot

_WIDTH = 100

SONAR_MA = {"ping": 35, "srf04": 50}
"""At most each. Ref: S6, S8."""


def wiring_text(robot: Robot) -> str:
    """Return the wiring of a robot as text; the same robot gives the same bytes."""
    parts = [
        f"Wiring of {plain(robot.name)}, a {robot.role}",
        *_table(f"Main controller, {robot.main.model}", main_pins(robot)),
        *_table(f"Locomotion controller, {robot.locomotion.model}", locomotion_pins(robot)),
        "",
        "Notes",
        "",
    ]
    for note in _notes(robot):
        parts += textwrap.wrap(note, _WIDTH, initial_indent="  - ", subsequent_indent="    ")
    return "\n".join(parts) + "\n"


def _table(title: str, uses: tuple[PinUse, ...]) -> list[str]:
    names = max(len(use.what) for use in uses)
    used = {use.pin for use in uses}
    lines = ["", title, ""]
    lines += [f"  {f'P{use.pin}':<5}{use.what:<{names}}  {use.wiring}" for use in uses]
    free = [f"P{pin}" for pin in range(16) if pin not in used]
    return [*lines, f"  free: {', '.join(free) or 'none'}"]


SERVO_LOADED_A, SERVO_STALLED_A = 0.25, 1.0
"""One servo's current. Ref: S10."""


def _supply(robot: Robot) -> str:
    """Return what the servos need: the legs that stand may stall, the others turn."""
    legs = len(robot.servo_set.servos) // 2
    up = min(sum(pose.up) for pose in robot.gait.poses if any(pose.up))
    stand = 2 * (legs - up)
    turn = 2 * legs - stand
    ampere = stand * SERVO_STALLED_A + turn * SERVO_LOADED_A
    all_a = 2 * legs * SERVO_STALLED_A
    return (
        f"Servos have a supply of their own, of the servos' voltage and for at least {ampere:g} A: "
        f"{stand} on the legs that stand in a step x {SERVO_STALLED_A:g} A, which one that is "
        f"stalled takes, and {turn} on those that are lifted x {SERVO_LOADED_A:g} A under load "
        "(S10). Legs are started one after another, or all would stall together "
        f"({all_a:g} A). Never from a Stamp's +5 V."
    )


def _notes(robot: Robot) -> list[str]:
    notes = [
        "One ground for both Stamps, the servo supply and all sensors. Both Stamps are switched "
        "on together: a Stamp without supply would be fed through its inputs.",
        _supply(robot),
        "Servos are analogue ones: the frames of pulses are 24 to 38 ms apart, which an analogue "
        "servo takes, with less torque beyond 20 ms, and a digital one may not (S29).",
        "Each servo's signal has 10 kohm to ground: from power-up to the first instruction the "
        "Stamp's pins float, and a servo may take what it picks up for a pulse.",
        "Each command line has 470 ohm in series and, at the locomotion controller, 10 kohm to "
        "ground: a main controller that is off or in reset then reads as 000.",
    ]
    if robot.link.step_line:
        notes.append(
            "The step line has one pull-up of 10 kohm to +5 V and 470 ohm in series. Both Stamps "
            "only ever pull it low."
        )
    else:
        notes.append(
            "There is no step line. While the main controller is off or in reset, the lines read "
            "000, which is FORWARD: lift the robot, or switch the servo supply on last."
        )
    notes.append(
        "Antennas: 10 kohm from the pin's side to +5 V, 220 ohm between that and the pin; the "
        "moving part is grounded. A touch reads 0."
    )
    if robot.light:
        notes.append(
            f"Light: photoresistor and a capacitor of {robot.light.capacitor_uf:g} uF in parallel "
            "from one point to ground, 220 ohm from that point to the pin. A larger capacitor "
            "makes the counts larger, so that the dark is reached earlier."
        )
        notes.append(
            "Photoresistors differ by tens of per cent from piece to piece: measure both on this "
            "robot and let `cgagen calibrate` write each one's curve. They work in the dark alone: "
            "where a room lights both all the time, the main controller says *BRIGHT behind its "
            "banner, takes that for the target and listens to no sonar."
        )
    kinds = {sonar.kind for sonar in robot.sonars}
    if "ping" in kinds:
        notes.append("PING))): +5 V, ground and SIG; 35 mA at most each (S6).")
    if "srf04" in kinds:
        notes.append("SRF04: +5 V, ground, trigger and echo; 50 mA at most each (S8).")
    milliampere = sum(SONAR_MA[sonar.kind] for sonar in robot.sonars)
    notes.append(
        f"All sonars together take {milliampere} mA: from the board's own 5 V regulator, made for "
        "that and both Stamps, and never from a Stamp's +5 V pin, whose regulator is for "
        "the module and little more."
    )
    grounded = [sonar.name for sonar in robot.sonars if robot.grounds_mode(sonar)]
    if grounded:
        notes.append(
            f"SRF04 {', '.join(plain(name.replace('_', ' ')) for name in grounded)}: the fifth pin "
            '(mode, "do not connect") goes to ground before it is switched on; the echo then '
            f"begins 300 us later, so that a {robot.main.model} sees it begin. Parts made before "
            'the end of April 2003 have no such mode (S8): for them say mode = "open" in '
            "the robot's file."
        )
    if any(sonar.mode == "open" and robot.main.model in SLOW_MODELS for sonar in robot.sonars):
        notes.append(
            f"An SRF04 with its mode pin open on a {robot.main.model} is only just in time, on low "
            "pins (S8). Where `cgagen verify` says that it is not, ground the mode pin."
        )
    notes.append(
        "The programming port of each Stamp is its own four-pin serial connection (SOUT, SIN, ATN, "
        "VSS) and takes none of the pins above."
    )
    return notes
