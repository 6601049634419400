"""Traces: what is said of a file that is none."""

import random
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import can
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cgagen.errors import TraceError
from hil.frames import Units, decision_frame, frames_of
from hil.target import Observation, Stimulus
from hil.traces import Sample, read_trace, write_trace
from hil.traces.candump import log_text
from hil.traces.questions import frames_of_samples
from hil.traces.vectors import header_of, parse_vectors, vectors_text
from tests.trace_cases import CALM, HEAD, PREDATOR, PREY, messages, parsed, predator, some

BAD_VECTORS = {
    "": "holds no header",
    "# only words\n": "holds no header",
    HEAD: "line 1: no reading follows",
    "front_counts,t_ms\n0,0": "line 1: column 1 is 'front_counts', where .* has t_ms",
    HEAD.replace("front_counts", "front_cm"): "column 2 is 'front_cm', .*front_counts or front_in",
    "t_ms,front_counts": "column 3 is 'nothing', .* has right_counts or right_in",
    HEAD + ",note": "behind the sensors may come state, command, latency_us",
    HEAD.replace("state,command", "command,state"): "each once and in this order",
    HEAD + "\n0,1,2": "line 2: has 3 cells and the header 11",
    HEAD + f"\n0,{CALM},,,,": "line 2: has 12 cells",
    HEAD + f"\n0,{CALM},,,\n\n# x\n-1,{CALM},,,": "line 5: t_ms is '-1': milliseconds",
    HEAD + f"\nnan,{CALM},,,": "t_ms is 'nan'",
    HEAD + f"\n1e3,{CALM},,,": "t_ms is '1e3'",
    HEAD + f"\n0.1234,{CALM},,,": "t_ms is '0.1234'",
    HEAD + f"\n0,65536{CALM[1:]},,,": "front_counts is '65536': a count is 0 to 65535",
    HEAD + f"\n0,{CALM[:-1]}x,,,": "light_right_counts is 'x'",
    HEAD + "\n0,0,0,0,2,0,0,0,,,": "antenna_left is '2': it is 1 for touched",
    HEAD + f"\n0,{CALM},64,,": "state 64 is none of a predator",
    HEAD + f"\n0,{CALM},,8,": "command is '8': a command is 0 to 7, or one of FORWARD",
    HEAD + f"\n0,{CALM},,WAIT,": "command is 'WAIT'",
    HEAD + f"\n0,{CALM},,,999999999": "latency_us is '999999999': it is 200000000 at most",
    HEAD + f"\n0,{CALM},,,1.2345": "latency_us is '1.2345'",
    HEAD + f"\n5,{CALM},,,\n4,{CALM},,,": "line 3: the time goes back from 5 ms to 4 ms",
}


@pytest.mark.parametrize(("text", "message"), BAD_VECTORS.items())
def test_wrong_vectors_are_refused_with_their_line(text: str, message: str) -> None:
    with pytest.raises(TraceError, match=message) as caught:
        parse_vectors(text, "v.csv", PREDATOR)
    assert str(caught.value).startswith("v.csv: ")
    assert caught.value.exit_code == 3


def test_a_header_is_of_one_robot() -> None:
    assert "light" not in header_of(PREY)
    with pytest.raises(TraceError, match="where a servobot-prey has front_left_counts"):
        parse_vectors(f"{HEAD}\n0,{CALM},,,", "v.csv", PREY)


# -- Frames that do not fit


A, B, LIGHT, APPLY, ANSWER = range(5)


def lines() -> list[str]:
    """Return three readings of five frames each."""
    reading = Stimulus((1843, 0, 700), (False, True), (0, 170))
    samples = [Sample(n * 10**9, reading, n + 1, 15, 3) for n in range(3)]
    return log_text(frames_of_samples(samples, PREDATOR)).splitlines()


def changed(change: Callable[[list[str]], Any]) -> str:
    rows = lines()
    change(rows)
    return "\n".join(rows) + "\n"


def put(index: int, old: str, new: str) -> Callable[[list[str]], None]:
    def change(rows: list[str]) -> None:
        assert old in rows[index]
        rows[index] = rows[index].replace(old, new)

    return change


FAULTY = frames_of(Stimulus((1, 0, 0), lights=(0, 0)), 1, Units.of(PREDATOR), 0x0100)[-1]
BAD_FRAMES: dict[str, tuple[Callable[[list[str]], Any], str]] = {
    "binary": (put(3, "104", "\x00\x01"), "line 4: .* is not like"),
    "no stamp": (put(6, "(1.000000) ", ""), "line 7: .* is not like"),
    "milliseconds": (put(6, "(1.000000)", "(1.000)"), "line 7: .* is not like"),
    "two lines in one": (put(0, " T", " T (0.000000)"), "line 1"),
    "cut in a frame": (lambda r: r.__setitem__(13, r[13][:26]), "line 14: .* bytes, not 8"),
    "cut in a byte": (
        lambda r: r.__setitem__(13, r[13][:27]),
        "line 14: ends in the middle of a byte",
    ),
    "cut before apply": (lambda r: r.__delitem__(slice(13, 15)), "line 13: the file ends before"),
    "empty": (lambda r: r.clear(), "a.log: holds no reading"),
    "no sonar frame": (lambda r: r.pop(5 + B), "line 8: STIM_SONAR_B is missing"),
    "no light": (lambda r: r.pop(5 + LIGHT), "line 8: reading 2 has 3 sonars and 0 light sensors"),
    "apply alone": (lambda r: r.__delitem__(slice(5, 8)), "line 6: STIM_SONAR_A is missing"),
    "no apply": (lambda r: r.pop(5 + APPLY), "line 9: a decision about reading 2, which is none"),
    "no apply, no answer": (
        lambda r: r.__delitem__(slice(8, 10)),
        "line 9: a frame of reading 3 in the middle of reading 2",
    ),
    "twice": (lambda r: r.insert(6, r[5]), "line 10: STIM_SONAR_A is there twice"),
    "reading lost": (lambda r: r.__delitem__(slice(5, 10)), "line 6: reading 3 follows 1"),
    "number back": (lambda r: r.extend(re_timed(r[:5], 9)), "line 16: the number goes back from 3"),
    "number again": (lambda r: r.extend(re_timed(r[10:], 9)), "line 16: the number goes back"),
    "time back": (
        put(10, "(2.0", "(0.9"),
        "line 11: the time goes back from 1.000000 s to 0.900000",
    ),
    "mixed numbers": (put(6, "0200 T", "0300 T"), "line 7: a frame of reading 3 in the middle of"),
    "foreign id": (put(5, "100#", "0FF#"), "line 6: 0FF is no message of rig.dbc"),
    "extended id": (put(5, "100#", "00000100#"), "line 6: has an extended identifier"),
    "remote": (put(5, re.sub(".*#", "", lines()[5]), "R8"), "line 6: has a remote frame"),
    "fd": (put(5, "100#", "100##0"), "line 6: has a CAN FD frame"),
    "other bus": (put(7, "can0", "can1"), "line 8: a frame of can1 among those of can0"),
    "short": (put(5, "100#", "100#00"), "line 6: STIM_SONAR_A has 9 bytes"),
    "fault": (
        lambda r: r.__setitem__(3, f"(0.000000) can0 104#{FAULTY.data.hex()} T"),
        "line 4: reading 1 has a fault",
    ),
    "prey": (
        lambda r: r.__setitem__(3, r[3].replace("104#0207", "104#023F")),
        "line 4: STIM_SONAR_C is missing",
    ),
    "mask": (lambda r: r.__setitem__(3, r[3].replace("104#0207", "104#0205")), "SONAR_MASK 000101"),
    "too long": (
        put(0, "100#" + lines()[0].split("#")[1][:6], "100#FFFFFF"),
        "line 4: .* is longer",
    ),
    "answer twice": (lambda r: r.insert(5, r[4]), "line 6: a second decision about reading 1"),
    "answer first": (lambda r: r.insert(0, r[4]), "line 1: a decision about reading 1, which is"),
    "answer to none": (put(4, "0100", "0900"), "line 5: a decision about reading 9"),
}


def re_timed(rows: list[str], second: int) -> list[str]:
    return [re.sub(r"\(\d+", f"({second}", row) for row in rows]


@pytest.mark.parametrize("case", BAD_FRAMES)
def test_wrong_frames_are_refused_with_their_line(case: str) -> None:
    change, message = BAD_FRAMES[case]
    with pytest.raises(TraceError, match=message) as caught:
        parsed(changed(change))
    assert str(caught.value).startswith("a.log: ")
    assert len(str(caught.value).splitlines()) == 1


def test_a_prey_has_no_state_11() -> None:
    plain = Stimulus((0,) * 6)
    frames = [*frames_of(plain, 1, Units.of(PREY)), decision_frame(Observation(1, 1, 11))]
    text = log_text((0, frame) for frame in frames)
    with pytest.raises(TraceError, match="line 5: state 11 is none of a prey"):
        parsed(text, PREY)


def test_late_answers_are_counted_and_others_messages_passed_over() -> None:
    rows = lines()
    status = "(1.000000) can0 081#0000000000000000 R"
    late = [*rows[:9], rows[4].replace("(0", "(1"), status, *rows[9:]]
    samples, stale = parsed("\n".join(late))
    assert (samples, stale) == (parsed("\n".join(rows))[0], 1)


def test_a_decision_that_was_none_is_none() -> None:
    rows = lines()
    rows[4] = rows[4].replace("#8B", "#00").replace("200#8", "200#0")
    assert int(rows[4].split("#")[1][:2], 16) & 8 == 0
    samples, _ = parsed("\n".join(rows))
    assert [one.decided for one in samples] == [False, True, True]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"is_extended_id": True}, "frame 1: has an extended identifier"),
        ({"is_remote_frame": True, "data": None, "dlc": 8}, "frame 1: has a remote frame"),
        ({"is_error_frame": True}, "frame 1: has an error"),
        ({"is_fd": True}, "frame 1: has a CAN FD frame"),
        ({"arbitration_id": 0x7FF}, "frame 1: 7FF is no message"),
        ({"data": b"\1"}, "frame 1: STIM_SONAR_A has 1 bytes"),
    ],
)
def test_frames_of_other_kinds_are_refused_whatever_the_format(
    changes: dict[str, Any], message: str, tmp_path: Path
) -> None:
    plain: dict[str, Any] = {"arbitration_id": 0x100, "data": bytes(8), "is_extended_id": False}
    path = tmp_path / "a.blf"
    with can.Logger(path) as writer:
        writer.on_message_received(can.Message(timestamp=0.0, channel=0, **(plain | changes)))
    with pytest.raises(TraceError, match=message):
        read_trace(path, PREDATOR)


def test_two_buses_in_one_file_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.asc"
    with can.Logger(path) as writer:
        for n, message in enumerate(messages(some(predator()), channel=0)):
            message.channel = int(n == 3)
            writer.on_message_received(message)
    with pytest.raises(TraceError, match="frame 4: a frame of bus 1 among those of 0"):
        read_trace(path, PREDATOR)


def test_times_from_frame_to_frame_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.asc"
    with can.Logger(path) as writer:
        for message in messages(some(predator()), channel=0):
            writer.on_message_received(message)
    text = path.read_text()
    assert "timestamps absolute" in text
    path.write_text(text.replace("timestamps absolute", "timestamps relative"))
    with pytest.raises(TraceError, match="its times count from frame to frame"):
        read_trace(path, PREDATOR)


@pytest.mark.parametrize("share", [0.2, 0.5, 0.9])
def test_a_cut_blf_is_refused_wherever_it_ends(share: float, tmp_path: Path) -> None:
    """It would be read as a shorter trace, where a container ends at the cut or is cut itself."""
    path = tmp_path / "a.blf"
    with can.Logger(path) as writer:
        for message in messages(some(predator(), 54), channel=0):
            writer.on_message_received(message)
    data = path.read_bytes()
    cut = int(len(data) * share)
    path.write_bytes(data[:cut])
    with pytest.raises(TraceError, match=f"byte {cut}: the file ends here, .* {len(data)} bytes"):
        read_trace(path, PREDATOR)


# -- Whatever else is in a file


@pytest.mark.parametrize("suffix", [".log", ".csv", ".asc", ".blf", ".trc", ".log.gz"])
@pytest.mark.parametrize("content", [b"", b"\xff\xfe\x00binary\x80" * 50, b"\n\n", b"LOGG" * 99])
def test_what_is_no_trace_is_one_sentence(suffix: str, content: bytes, tmp_path: Path) -> None:
    path = tmp_path / f"a{suffix}"
    path.write_bytes(content)
    with pytest.raises(TraceError) as caught:
        read_trace(path, PREDATOR)
    assert str(caught.value).startswith(f"{path}: ")


def test_a_missing_file_and_an_unknown_kind(tmp_path: Path) -> None:
    for suffix in (".log", ".csv", ".asc", ".blf", ".log.gz"):
        with pytest.raises(TraceError, match=r"cannot be read \(No such file"):
            read_trace(tmp_path / f"none{suffix}", PREDATOR)
    with pytest.raises(TraceError, match=r"name ends in \.csv, \.log"):
        read_trace(tmp_path / "none.xlsx", PREDATOR)


def spoil(data: bytes, chance: random.Random) -> bytes:
    """Return bytes with a few of them, or of their lines, gone, doubled or changed."""
    for _ in range(chance.randrange(1, 4)):
        rows = data.split(b"\n")
        at, row = chance.randrange(len(data) or 1), chance.randrange(len(rows))
        kind = chance.randrange(6)
        if kind == 0:
            data = data[:at]
        elif kind == 1:
            data = data[:at] + bytes([chance.randrange(256)]) + data[at + 1 :]
        elif kind == 2:
            data = b"\n".join([*rows[:row], *rows[row + 1 :]])
        elif kind == 3:
            data = b"\n".join([*rows[:row], *rows[row:][:1], *rows[row:]])
        elif kind == 4:
            data = data[:at] + data[at + chance.randrange(20) :]
        else:
            data = data[:at] + data[at : at + 9] * 2 + data[at:]
    return data


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """Return the same trace in all formats, and a sidecar, by suffix."""
    folder = tmp_path_factory.mktemp("good")
    trace = some(predator())
    for suffix in (".asc", ".blf", ".trc"):
        with can.Logger(folder / f"a{suffix}") as writer:
            for message in messages(trace, channel=0):
                writer.on_message_received(message)
    for suffix in (".csv", ".log"):
        write_trace(folder / f"a{suffix}", trace, PREDATOR)
    shutil.move(folder / "a.log.json", folder / "sidecar.log.json")
    (folder / "a.csv.json").unlink()
    return {"".join(path.suffixes): path.read_bytes() for path in sorted(folder.glob("*.*"))}


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 2**32))
@pytest.mark.parametrize("suffix", [".log", ".csv", ".asc", ".blf", ".trc", ".log.json"])
def test_a_spoiled_file_is_a_trace_or_one_sentence(
    good: dict[str, bytes], suffix: str, seed: int, tmp_path_factory: pytest.TempPathFactory
) -> None:
    folder = tmp_path_factory.getbasetemp() / "spoiled"
    folder.mkdir(exist_ok=True)
    for path in folder.iterdir():
        path.unlink()
    content = spoil(good[suffix], random.Random(seed))
    name = suffix.removesuffix(".json")
    (folder / f"a{name}").write_bytes(good[name])
    (folder / f"a{suffix}").write_bytes(content)
    trace, said = None, ""
    try:
        trace = read_trace(folder / f"a{name}", PREDATOR)
    except TraceError as error:
        said = str(error)
    if trace is None:
        assert said.startswith(str(folder))
        assert len(said.splitlines()) == 1
        return
    assert trace.samples
    again = parse_vectors(vectors_text(trace, PREDATOR), "again.csv", PREDATOR)
    assert again.stimuli == trace.stimuli


@settings(max_examples=40, deadline=None)
@given(text=st.text(max_size=200))
def test_any_text_is_refused_in_one_sentence(text: str) -> None:
    for read in (lambda: parsed(text), lambda: parse_vectors(text, "a.csv", PREDATOR)):
        with pytest.raises(TraceError):
            read()
