"""The words of the locomotion controller's template: pulses, tables and pins as lines."""

from typing import Any

from cgagen import bench_protocol as protocol
from cgagen.firmware.columns import con, data, declare
from cgagen.firmware.common_words import (
    common_words,
    movement_legend,
    nibble,
    port_constants,
)
from cgagen.firmware.gait_tables import GaitTables, Row, SwingTable, gait_tables
from cgagen.firmware.pins import locomotion_pins, servo_pin_name
from cgagen.genome import Genome
from cgagen.robot.gait import frames_of
from cgagen.robot.values import LEGS, Robot, Servo
from cgagen.stamp.chips import chip

IDLE_FRAMES = 250
"""Frames without GO before that is reported: more than 4 s, and it fits a byte. Choice."""

READ_TRIES = 5
"""Readings of the command lines before they are reported. Choice."""

SHORTEST_LISTEN_MS = 30
"""A slice with the frame and the prompt that go with it, at least: 12 pulses of 1.5 ms."""

_COLUMN = 5


def locomotion_words(robot: Robot, genome: Genome | None) -> dict[str, Any]:
    """Return the words of a locomotion controller's template."""
    model = chip(robot.locomotion.model)
    uses = locomotion_pins(robot)
    tables = gait_tables(robot)
    return (
        common_words(robot, model, uses)
        | {
            "title": f"{protocol.plain(robot.name)}: locomotion controller, {model.name}",
            "genome_note": _genome_note(robot, genome),
            "pins": [
                {"declaration": declare(use.name, "PIN", use.pin, use.what)}
                for use in uses
                if use.name
            ],
            "command_input": f"IN{nibble(robot.link.locomotion_pins)}",
            "constants": _constants(robot, tables),
            "pulse_unit": f"{robot.locomotion.pulsout_unit_ns * tables.pulse_step / 1000:g}",
            "legs": list(LEGS),
            "first_leg": LEGS[0],
            "swing_list": ", ".join(f"swing{leg}" for leg in LEGS),
            "lift_list": ", ".join(f"lift{leg}" for leg in LEGS),
            "servo_pulses": [
                {
                    "pin_name": servo_pin_name(servo),
                    "variable": f"{'swing' if servo.joint == 'horizontal' else 'lift'}{servo.leg}",
                    "label": _label(servo),
                }
                for servo in robot.servo_set.servos
            ],
            "rise_labels": ", ".join(f"From{leg}" for leg in LEGS[:0:-1]),
            "first_outputs": _first_outputs(robot),
            "holds": any(move.turn == 0 for move in tables.moves),
            "between_frames": True,
            "bench_note": (
                "No GO is accepted." if robot.link.step_line else "The lines are not read."
            ),
        }
        | _gait(robot, tables)
    )


def _genome_note(robot: Robot, genome: Genome | None) -> str:
    if genome:
        return f"Genome:  {genome.digest[:8]}, the main controller's; this one has the gait alone"
    return f"File:    {robot.digest[:8]}, the first digits of the robot file's SHA-256"


def _constants(robot: Robot, tables: GaitTables) -> list[str]:
    model = chip(robot.locomotion.model)
    tries = -(-protocol.LISTEN_MS // SHORTEST_LISTEN_MS)
    unit_us = robot.locomotion.pulsout_unit_ns / 1000
    lines = port_constants(model, protocol.LOCOMOTION_SLICE_MS, tries)
    if robot.link.step_line:
        lines.append(con("IdleFrames", IDLE_FRAMES, "frames, some seconds, that GO may take"))
    return [
        *lines,
        con("ReadTries", READ_TRIES, "readings of the command lines"),
        con("PulseStep", tables.pulse_step, f"counts of {unit_us:g} us in one step of a pulse"),
        con("LiftFrames", robot.gait.lift_frames, f"frames to lift a leg {robot.gait.lift_deg:g}"
            " deg"),
        con("LowerFrames", robot.gait.lower_frames, "frames to set it down"),
        con("StartFrames", robot.servo_set.start_frames, "frames to bring a leg to the centre"),
    ]  # fmt: skip


def _first_outputs(robot: Robot) -> list[str]:
    """The first statement: every servo line low."""
    pins = [servo.pin for servo in robot.servo_set.servos]
    mask = "".join("1" if pin in pins else "0" for pin in range(15, -1, -1))
    return [f"{'DIRS = %' + mask:<46}' servo lines low"]


def _label(servo: Servo) -> str:
    """Return where a frame for some legs begins; the legs behind the first have such a place."""
    begins = servo.joint == "horizontal" and servo.leg != LEGS[0]
    return f"From{servo.leg}" if begins else ""


def _gait(robot: Robot, tables: GaitTables) -> dict[str, Any]:
    servo_set, unit_us = robot.servo_set, robot.locomotion.pulsout_unit_ns / 1000
    step_us = tables.pulse_step * unit_us
    return {
        "gait_notes": [
            f"Every byte is a final pulse in steps of {step_us:g} us: "
            f"{servo_set.centre_counts} counts for the centre, {servo_set.counts_per_deg:g} for",
            "a degree, times the direction, and the servo's trim. Six poses, one a row. up: legs",
            "that are lifted; forward: legs at + their side's swing, the others at -; both in the",
            f"order of the columns, {' '.join(LEGS)}.",
        ],
        "swing_tables": [_swing_table(robot, tables, table) for table in tables.swings],
        "lift_note": f"Vertical: a lifted leg is up by {robot.gait.lift_deg:g} deg.",
        "lift_rows": [
            data("Lifts" if index == 0 else "", row, _COLUMN, f"pose {index}: up {_mask(pose.up)}")
            for index, (row, pose) in enumerate(zip(tables.lifts, robot.gait.poses, strict=True))
        ],
        "stand_note": "Standing: all legs down and straight out.",
        "stand_rows": [
            data("Stand", tables.stand_swing, _COLUMN, "horizontal"),
            data("", tables.stand_lift, _COLUMN, "vertical"),
        ],
        "moves_note": "Movements: swing table, first pose, turn, frames of a push (0 turn: hold).",
        "move_rows": _move_rows(robot, tables),
        "movement_legend": movement_legend(robot),
    }


def _swing_table(robot: Robot, tables: GaitTables, table: SwingTable) -> dict[str, Any]:
    users = [str(move.step.movement) for move in tables.moves if move.table == table.label
             and move.turn]  # fmt: skip
    return {
        "notes": [
            f"{', '.join(users)}:",
            f"left legs at {table.left_deg:+g} deg when forward, "
            f"right legs at {table.right_deg:+g} deg.",
        ],
        "rows": [
            data(
                table.label if index == 0 else "",
                row,
                _COLUMN,
                f"pose {index}: forward {_mask(pose.forward)}",
            )
            for index, (row, pose) in enumerate(zip(table.rows, robot.gait.poses, strict=True))
        ],
    }


def _move_rows(robot: Robot, tables: GaitTables) -> list[str]:
    rows = []
    for command, move in enumerate(tables.moves):
        frames = frames_of(robot, move.step)
        items: Row | tuple[object, ...] = (move.table, move.first_pose, move.turn, move.frames)
        note = f"{command} {move.step.movement}, {frames} frames"
        rows.append(data("Moves" if command == 0 else "", items, 8, note))
    return rows


def _mask(flags: tuple[bool, ...]) -> str:
    """Return the flags as the robot's file writes them.

    >>> _mask((True, False, True, False, True, False))
    '101010'
    """
    return "".join("1" if flag else "0" for flag in flags)
