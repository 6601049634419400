"""The words of the main controllers' templates: every number final, every row a line."""

from typing import Any

from cgagen import bench_protocol as protocol
from cgagen.counts import FARTHEST_COUNT
from cgagen.firmware.columns import camel, con, data, declare
from cgagen.firmware.common_words import (
    common_words,
    movement_legend,
    nibble,
    port_constants,
    serin_units,
)
from cgagen.firmware.pins import main_pins, sonar_pin_names
from cgagen.firmware.timing import least_step_ms, legs_start_ms, step_timeout_ms
from cgagen.genome import Genome
from cgagen.robot.values import Robot, Sonar
from cgagen.stamp.chips import chip
from cgagen.words import COMMANDS, Movement, Role, Situation, situation_name

POLL_MS = 5
"""Between two looks at the step line. Choice."""

SLOW_POLL_MS = 7
"""The same with what a slow chip does besides. Choice: a BS2 takes 1.5 ms for a turn."""

GENE_COLUMN = 7

RULE = 95
"""Characters of a heading's rule."""


def main_words(robot: Robot, genome: Genome | None) -> dict[str, Any]:
    """Return the words of a main controller's template."""
    model = chip(robot.main.model)
    uses = main_pins(robot)
    letter = nibble(robot.link.main_pins)
    words = common_words(robot, model, uses) | {
        "title": f"{protocol.plain(robot.name)}: main controller, {model.name}",
        "pins": [
            {"declaration": declare(use.name, "PIN", use.pin, use.what)} for use in uses if use.name
        ],
        "command_latch": f"OUT{letter}",
        "command_dirs": f"DIR{letter}",
        "echo_unit": f"{robot.main.pulsin_unit_ns / 1000:g}",
        "light_unit": f"{robot.main.rctime_unit_ns / 1000:g}",
        "counts_per_inch": f"{robot.echo_counts_per_in:.1f}",
        "sonars": [_sonar(sonar) | {"rests": _rests(robot, sonar)} for sonar in robot.sonars],
        "light_sensors": [
            {"pin_name": f"Lamp{camel(one.name)}", "variable": f"light{camel(one.name)}"}
            for one in (robot.light.sensors if robot.light else ())
        ],
        "readings": _readings(robot),
        "telemetry_items": _telemetry(robot),
        "movement_legend": movement_legend(robot),
        "between_frames": False,
        "leave_to": "Hunt" if robot.role is Role.PREDATOR else "Flee",
        "constants": _constants(robot),
    }
    return words | (_predator(robot, genome) if genome else _prey(robot))


def _sonar(sonar: Sonar) -> dict[str, Any]:
    names = sonar_pin_names(sonar)
    return {
        "name": camel(sonar.name),
        "kind": sonar.kind,
        "pin_name": names[0],
        "trigger_name": names[0],
        "echo_name": names[-1],
    }


def _rests(robot: Robot, sonar: Sonar) -> bool:
    """Whether there is a rest behind a sonar: GO takes longer than one, so the last needs none."""
    return sonar is not robot.sonars[-1] or robot.link.step_line is None


def _readings(robot: Robot) -> list[str]:
    lights = robot.light.sensors if robot.light else ()
    return [f"echo({camel(sonar.name)})" for sonar in robot.sonars] + [
        f"light{camel(sensor.name)}" for sensor in lights
    ]


def _telemetry(robot: Robot) -> list[dict[str, str]]:
    keys = [*protocol.SONAR_KEYS[robot.role], *(protocol.LIGHT_KEYS if robot.light else ())]
    keys += [*protocol.ANTENNA_KEYS, protocol.STATE_KEY, protocol.COMMAND_KEY]
    variables = [*_readings(robot), "antennas.BIT0", "antennas.BIT1", "state", "command"]
    return [{"key": key, "variable": name} for key, name in zip(keys, variables, strict=True)]


def _constants(robot: Robot) -> list[str]:
    model = chip(robot.main.model)
    tries = -(-protocol.LISTEN_MS // protocol.MAIN_SLICE_MS)
    lines = port_constants(model, protocol.MAIN_SLICE_MS, tries)
    reading = serin_units(model, protocol.READING_MS)
    lines.append(con("ReadingTime", reading, f"{protocol.READING_MS} ms, likewise, in bench mode"))
    if robot.link.step_line:
        timeout_ms, least = step_timeout_ms(robot), least_step_ms(robot)
        lines += [
            con("GoTime", protocol.GO_MS, "ms that the step line is held low for GO"),
            con("LegsTime", legs_start_ms(robot) - protocol.LISTEN_MS, "ms that the legs take to rise"),
            con("PollTime", POLL_MS, "ms between two looks at the step line"),
            con(
                "StepPolls", -(-timeout_ms // POLL_MS), f"{timeout_ms} ms, longer than any movement"
            ),
            con("LeastPolls", least // SLOW_POLL_MS, f"{least} ms, shorter than any movement"),
        ]
    # Rounded up: a trigger may be longer than the data sheet's least, never shorter.
    trigger = int(-(-robot.echo.trigger_us * 1000 // robot.main.pulsout_unit_ns))
    lines += [
        "",
        con("Trigger", trigger, f"sonar trigger, {robot.echo.trigger_us:g} us"),
        con("EchoGap", robot.echo.trigger_gap_ms, "ms, or a sonar hears the burst of another"),
        con("EchoMs", -(-1_000_000 // robot.main.pulsin_unit_ns), "counts of an echo in 1 ms"),
        con("NoEcho", FARTHEST_COUNT, "farther than everything"),
    ]
    if robot.light:
        lines.append(con("ChargeTime", robot.light.charge_ms, "ms to charge a light capacitor"))
    lines += ["", "' Sonars, by index of echo."]
    lines += [con(camel(sonar.name), index) for index, sonar in enumerate(robot.sonars)]
    return lines + (_limits(robot) if robot.limits else _causes(robot))


def _limits(robot: Robot) -> list[str]:
    """The predator's thresholds and situations as constants."""
    assert robot.limits is not None  # a predator's, as is the next
    assert robot.light is not None
    limits, counts = robot.limits, robot.situation_counts
    rows: tuple[tuple[str, int, float], ...] = (
        ("EchoFrontNear", counts.front_near, limits.front_near_in),
        ("EchoFrontMiddle", counts.front_middle, limits.front_middle_in),
        ("EchoFrontFar", counts.front_far, limits.front_far_in),
        ("EchoSideNear", counts.side_near, limits.side_near_in),
        ("EchoSideFar", counts.side_far, limits.side_far_in),
    )
    lamps = (("Left", counts.lamp_left), ("Right", counts.lamp_right))
    rows += tuple(
        row
        for side, lamp in lamps
        for row in (
            (f"{side}LampNear", lamp.front_near, limits.target_front_near_in),
            (f"{side}LampMiddle", lamp.front_middle, limits.target_front_middle_in),
            (f"{side}LampSide", lamp.side_near, limits.target_side_near_in),
            (f"{side}LampRange", lamp.range, robot.light.range_in),
        )
    )
    lines = ["", "' Limits in counts. A reading is nearer when it is less, never when it is equal."]
    for name, count, inches in rows:
        note = f", {robot.light.condition}" if name.endswith("LampRange") else ""
        lines.append(con(name, count, f"{inches:g} in{note}"))
    lines += ["", "' Situations of obstacle and target, by row and column of the table."]
    names = ["Nothing", *(camel(one.name.lower()) for one in list(Situation)[1:])]
    return lines + [con(name, number) for number, name in enumerate(names)]


def _causes(robot: Robot) -> list[str]:
    """The prey's threshold and states as constants."""
    assert robot.reflex is not None  # a prey's
    return [
        "",
        "' The limit in counts. A reading is nearer when it is less, never when it is equal.",
        con("Alarm", robot.alarm_count, f"{robot.reflex.policy.alarm_in:g} in"),
        "",
        "' States, by row of the table: what decides.",
        con("Calm", protocol.PREY_CALM, "nothing is near"),
        con("FirstSonar", protocol.PREY_FIRST_SONAR, "and the others behind it"),
        con("TouchedLeft", protocol.PREY_ANTENNA_LEFT),
        con("TouchedRight", protocol.PREY_ANTENNA_RIGHT),
        con("BothLeftOpen", protocol.PREY_BOTH_LEFT_OPEN, "more room at the left"),
        con("BothRightOpen", protocol.PREY_BOTH_RIGHT_OPEN, "at the right, or equally much"),
    ]


def _predator(robot: Robot, genome: Genome) -> dict[str, Any]:
    assert robot.limits is not None  # a predator's
    commands = genome.commands()
    size = len(Situation)
    columns = [situation_name(one, "target").split("_") for one in Situation]
    head = [
        "".join(f"{column[part]:<{GENE_COLUMN}}" for column in columns).rstrip() for part in (0, 1)
    ]
    return {
        "genome_note": f"Genome:  {genome.digest[:8]}, the first digits of its bits' SHA-256",
        "masking": robot.limits.masking,
        "gene_header": head,
        "genes": [
            data(
                "Genes" if row == 0 else "",
                commands[row * size : (row + 1) * size],
                GENE_COLUMN,
                situation_name(Situation(row), "object"),
            )
            for row in range(size)
        ],
    }


def _prey(robot: Robot) -> dict[str, Any]:
    assert robot.reflex is not None  # a prey's
    reflex, code = robot.reflex, {move: n for n, move in enumerate(COMMANDS[robot.role])}
    rows = [("nothing is near", Movement.WAIT)]
    for sonar, answer in zip(robot.sonars, reflex.policy.answers, strict=True):
        rows.append((f"nearest: {sonar.name.replace('_', ' ')}", answer))
    rows += [
        ("antenna left", reflex.antenna_left),
        ("antenna right", reflex.antenna_right),
        ("both antennas, left side open", reflex.both_left_open),
        ("both antennas, right side open", reflex.both_right_open),
    ]
    policy = protocol.plain(reflex.policy_name)
    return {
        "genome_note": f"File:    {robot.digest[:8]}, the first digits of the robot file's SHA-256",
        "policy_name": policy,
        "policy_rule": "-" * (RULE - len(f"' -----[ The reflex: policy {policy!r} ]")),
        "answers": [
            data("Answers" if state == 0 else "", (code[move],), 4, f"{state}: {what} - {move}")
            for state, (what, move) in enumerate(rows)
        ],
    }
