"""The firmware's lines in words: readings in inches, situations, movements, faults."""

from collections.abc import Iterator
from typing import Any, NamedTuple

from cgagen.bench_protocol import (
    ANSWER,
    END,
    FAULT,
    PROMPT,
    TELEMETRY,
    Fault,
    parse_banner,
    plain,
)
from cgagen.counts import NO_ECHO_COUNT, UNLIT_COUNT
from cgagen.monitor.suspects import Suspects
from cgagen.robot import Robot, Sonar, load_robot, shipped
from cgagen.telemetry import Telemetry, parse_telemetry, prey_reason, role_in
from cgagen.words import COMMANDS, GENES, Role, situation_name, situations_of

LONGEST_LINE = 200
"""Characters without an end of line that are kept; no line of ours is half as long. Choice."""

FAULTS: dict[Fault, str] = {
    Fault.BUSY: "the step line has been low for longer than the longest movement takes",
    Fault.REFUSED: "no locomotion controller has accepted it: off, starting, or in bench mode",
    Fault.CUT: "the step before was not walked to its end; the locomotion controller started anew",
    Fault.BRIGHT: "both light sensors are lit at the start; unless the lamp is ahead the room is "
    "too bright for their limits, so no sonar is listened to: make it dark, or calibrate",
    Fault.LOW: "something else holds the step line low",
    Fault.IDLE: "no command for some seconds",
    Fault.LINES: "the command lines never read the same twice",
}
"""What each means. Ref: PROTOCOL.md."""


class Line(NamedTuple):
    """One line of the chip's.

    Attributes:
        text: in words; the line itself where it is none of the firmware's.
        data: likewise for a program, with its `kind` first.
        said: what a line of telemetry says; None for others.
    """

    text: str
    data: dict[str, Any]
    said: Telemetry | None = None


class Decoder:
    r"""Turns what a main or locomotion controller sends into lines in words.

    Args:
        robot: whose counts they are; None for the robot that ships and is named by the banner,
            or, where it has been walking for long, has such telemetry.

    Attributes:
        robot: whose counts the lines are taken for.
        named: whether a robot was named; then no banner changes it.

    >>> from cgagen.robot import load_robot
    >>> decoder = Decoder(load_robot("servobot-predator"))
    >>> [line] = decoder.lines(b">:3 F1967 R0 L24666 LL170 LR0 AL1 AR0 S43 C3\r")
    >>> print(line.text.replace("; ", ";\n   "))
    3: front 10.0 in, right no echo, left nothing;
       lamp left 12.0 in, right dark;
       right touched;
       near_front, near_left: state 43, LEFT_FORWARD
    >>> [line.text for line in decoder.lines(b"*REFUSED\r")]
    ['fault REFUSED: no locomotion controller has accepted it: off, starting, or in bench mode']
    """

    def __init__(self, robot: Robot | None) -> None:
        self.robot = robot or load_robot(f"servobot-{Role.PREDATOR}")
        self.named = robot is not None
        self._text = ""
        self._suspects: Suspects | None = None
        self._watched = self.robot

    def lines(self, data: bytes) -> Iterator[Line]:
        """Return the lines that end within the next bytes."""
        *whole, self._text = (self._text + data.decode("latin-1")).split(END)
        self._text = self._text[-LONGEST_LINE:]
        for text in whole:
            if not self.named:
                self._follow(text)
            line = self._line(text)
            if line is not None:
                yield line
            if line is not None and line.said is not None:
                yield from self._notes(line.said)

    def _notes(self, said: Telemetry) -> Iterator[Line]:
        """Return what is wrong with the sensors, as lines behind the decision that shows it."""
        if self._suspects is None or self._watched is not self.robot:
            self._suspects, self._watched = Suspects(self.robot), self.robot
        for note in self._suspects.add(said):
            yield Line(f"note: {note}", {"kind": "note", "text": note})

    def _follow(self, text: str) -> None:
        banner, role = parse_banner(text), role_in(text)
        if banner is not None and banner.robot in shipped("robot"):
            self.robot = load_robot(banner.robot)
        elif role is not None and role is not self.robot.role:
            self.robot = load_robot(f"servobot-{role}")

    def _line(self, text: str) -> Line | None:
        if TELEMETRY in text:
            said = parse_telemetry(text, self.robot.role)
            if said is not None:
                return self._decision(said)
        banner = parse_banner(text)
        if banner is not None:
            words = f"{banner.chip} controller of {banner.robot}, genome {banner.genome}"
            other = "" if banner.robot == plain(self.robot.name) else f"; read as {self.robot.name}"
            return Line(words + other, {"kind": "banner", **banner._asdict()})
        for sign, kind in ((FAULT, "fault"), (ANSWER, "answer")):
            before, found, word = text.rpartition(sign)
            if found and set(before) <= {PROMPT} and word.isprintable():
                return _signed(kind, word)
        bare = "".join(one for one in text if one.isprintable()).strip(PROMPT)
        return Line(bare, {"kind": "text", "text": bare}) if bare else None

    def _decision(self, said: Telemetry) -> Line:
        robot = self.robot
        sonars = [
            (sonar.name, _echo(robot, sonar, count))
            for sonar, count in zip(robot.sonars, said.sonars, strict=True)
        ]
        parts = [", ".join(f"{name} {_inches(where)}" for name, where in sonars)]
        data: dict[str, Any] = {"kind": "decision", **said._asdict()}
        data["sonars_in"] = {name: where for name, where in sonars if isinstance(where, float)}
        if robot.light is not None:
            lights = [
                (sensor.name, _distance(robot, side, count))
                for side, (sensor, count) in enumerate(
                    zip(robot.light.sensors, said.lights, strict=True)
                )
            ]
            parts.append("lamp " + ", ".join(f"{name} {_inches(where)}" for name, where in lights))
            data["lights_in"] = {name: where for name, where in lights if isinstance(where, float)}
        touched = [side for side, bent in zip(("left", "right"), said.touched, strict=True) if bent]
        parts += [f"{' and '.join(touched)} touched"] if touched else []
        movement = _movement(robot, said.command)
        why = _reason(robot, said.state)
        data |= {"situation": why, "movement": movement}
        parts.append(f"{why}: state {said.state}, {movement}")
        return Line(f"{said.number}: {'; '.join(parts)}", data, said)


def _signed(kind: str, word: str) -> Line:
    meaning = FAULTS.get(Fault(word)) if kind == "fault" and word in Fault.__members__ else None
    text = f"{kind} {word}: {meaning}" if meaning else f"{kind} {word}"
    return Line(text, {"kind": kind, "word": word})


def _movement(robot: Robot, command: int) -> str:
    commands = COMMANDS[robot.role]
    return str(commands[command]) if command < len(commands) else f"command {command}"


def _reason(robot: Robot, state: int) -> str:
    """Return what a state says, in words."""
    if robot.role is Role.PREDATOR:
        if state >= GENES:
            return "no such state"
        obstacle, target = situations_of(state)
        return f"{situation_name(obstacle, 'object')}, {situation_name(target, 'target')}"
    return prey_reason(state, [one.name for one in robot.sonars]) or "no such state"


def _inches(where: float | str) -> str:
    return f"{where:.1f} in" if isinstance(where, float) else where


def _echo(robot: Robot, sonar: Sonar, count: int) -> float | str:
    """Return the distance of an echo, or why there is none."""
    if count == NO_ECHO_COUNT:
        return "no echo"
    if count >= int(robot.echo_limits_counts(sonar)[1]):
        return "nothing"
    return count / robot.echo_counts_per_in


def _distance(robot: Robot, side: int, count: int) -> float | str:
    """Return the distance of the lamp by its curve, or why there is none."""
    if robot.light is None or count == UNLIT_COUNT:
        return "dark"
    points = robot.light.sensors[side].curve
    if count >= points[-1][1]:
        return f"past {points[-1][0]:g} in"
    far = next(index for index, point in enumerate(points) if count < point[1])
    if far == 0:
        return points[0][0]
    (near_in, less), (far_in, more) = points[far - 1], points[far]
    return near_in + (far_in - near_in) * (count - less) / (more - less)
