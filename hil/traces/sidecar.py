"""What lies beside a trace: where it comes from, and the digests that tie it to that.

The file is `NAME.json` beside `NAME`, and `rig.dbc` lies in the same folder, so that any CAN tool
can read the frames. Neither has to be there; what is there has to fit.
"""

import json
from pathlib import Path
from typing import Any

from cgagen.files import digest
from cgagen.inputs import SIDECAR, TRACE, read_bytes, read_bytes_if_there
from cgagen.notations import parse_json
from cgagen.robot import Robot, load_robot, shipped
from cgagen.words import Role
from hil.dbc import dbc_text
from hil.messages import TICK_NS
from hil.traces.values import Origin, refused

FORMAT = "cgagen-trace-1"
DBC_FILE = "rig.dbc"
HAND = "hand"
TARGETS = ("simulator", "emulator", "serial", "can", HAND)
CLOCKS = ("nominal", "host")


def sidecar_path(path: Path) -> Path:
    """Return the sidecar of a trace's file.

    >>> sidecar_path(Path("hunt.log")).name
    'hunt.log.json'
    """
    return path.with_name(path.name + ".json")


def sidecar_text(origin: Origin, data: bytes, readings: int, robot: Robot) -> str:
    """Return the sidecar of a file with this content.

    A robot that does not ship goes in whole, so that the trace can be read without being told
    whose it is.
    """
    of_robot = {"name": origin.robot, "role": str(origin.role), "digest": origin.robot_digest}
    if not _ships(robot):
        of_robot["file"] = robot.text
    row: dict[str, Any] = {
        "format": FORMAT,
        "trace": digest(data),
        "readings": readings,
        "target": origin.target,
        "robot": of_robot,
        "genome": origin.genome,
        "images": dict(sorted(origin.images.items())),
        "dbc": digest(dbc_text()),
        "tick_ns": TICK_NS,
        "seed": origin.seed,
        "clock": origin.clock,
        "source": origin.source,
    }
    return json.dumps(row, indent=2) + "\n"


def read_origin(path: Path, name: str) -> Origin | None:
    """Return what the sidecar of a trace says; None where there is none.

    Args:
        path: of the trace.
        name: what messages call the trace.

    Raises:
        TraceError: the sidecar is none, or not of this content; another DBC lies beside it.
    """
    _check_dbc(path, name)
    beside = sidecar_path(path)
    where = sidecar_path(Path(name))
    content = read_bytes_if_there(beside, SIDECAR)
    if content is None:
        return None
    try:
        row = parse_json(content)
    except ValueError as error:
        raise refused(where, "", f"is no JSON ({error})") from error
    origin = _origin(row, str(where))
    _check_content(row, path, name, str(where))
    return origin


def _check_dbc(path: Path, name: str) -> None:
    text = read_bytes_if_there(path.with_name(DBC_FILE), SIDECAR)
    if text is not None and text != dbc_text().encode():
        raise refused(
            name,
            "",
            f"the {DBC_FILE} beside it is not this rig's, so its frames mean other things",
            "take the trace to a folder of its own if they do not",
        )


def _check_content(row: dict[str, Any], path: Path, name: str, where: str) -> None:
    if row["dbc"] != digest(dbc_text()):
        raise refused(name, "", f"{where} says that it was recorded by another {DBC_FILE}")
    if row["tick_ns"] != TICK_NS:
        raise refused(where, "tick_ns", f"is {row['tick_ns']}, and a rig's is {TICK_NS}")
    if row["trace"] != digest(read_bytes(path, TRACE)):
        raise refused(
            name,
            "",
            f"its content is not what {where} was written for",
            "record it again, or remove that file if the change was meant",
        )


def _origin(row: Any, where: str) -> Origin:
    """Return the origin in a sidecar whose every key is of the right kind."""
    kinds: dict[str, Any] = {
        "format": str,
        "trace": str,
        "readings": int,
        "target": str,
        "robot": dict,
        "genome": (str, type(None)),
        "images": dict,
        "dbc": str,
        "tick_ns": int,
        "seed": (int, type(None)),
        "clock": str,
        "source": dict,
    }
    if not isinstance(row, dict) or row.get("format") != FORMAT:
        raise refused(where, "format", f"is not {FORMAT}")
    for key, kind in kinds.items():
        if key not in row or not isinstance(row[key], kind) or isinstance(row[key], bool):
            raise refused(where, key, "is missing, or of another kind")
    robot = row["robot"]
    values = [robot.get("name"), robot.get("role"), robot.get("digest"), *row["images"].values()]
    if not all(isinstance(value, str) for value in values) or robot["role"] not in list(Role):
        raise refused(
            where, "robot", "name, role and digest are wanted, or images has other than text"
        )
    file = robot.get("file")
    if file is not None and (not isinstance(file, str) or digest(file) != robot["digest"]):
        raise refused(where, "robot", "its file is not what its digest says")
    if row["target"] not in TARGETS or row["clock"] not in CLOCKS:
        raise refused(where, "target", f"one of {', '.join(TARGETS)} is wanted, and its clock")
    return Origin(
        row["target"],
        robot["name"],
        Role(robot["role"]),
        robot["digest"],
        row["genome"],
        row["images"],
        row["seed"],
        row["clock"],
        row["source"],
        file,
    )


def _ships(robot: Robot) -> bool:
    return robot.name in shipped("robot") and load_robot(robot.name).digest == robot.digest
