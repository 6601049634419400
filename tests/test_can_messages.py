"""The table of CAN messages, its DBC file, and the way from a stimulus to frames and back."""

import importlib.util
import itertools
import random
import re
from functools import cache
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cgagen.stamp.chips import CHIPS, Chip
from hil.dbc import DBC_FILE, dbc_text
from hil.frames import (
    Frame,
    Question,
    Units,
    count_of_ticks,
    decision_frame,
    decision_of,
    frame,
    frames_of,
    middle_ticks,
    question_frames,
    question_of,
    stimulus_of,
)
from hil.messages import (
    BY_ID,
    FRAME_BYTES,
    MESSAGES,
    OBS_DECISION,
    RIG_CMD,
    STIM_APPLY,
    STIM_LIGHT,
    STIM_SONARS,
    TICK_NS,
    Fault,
    Message,
    Op,
    Report,
    State,
    pack,
    unpack,
)
from hil.target import Observation, Stimulus

BS2P = Units(750, 750)
READING = Stimulus((1843, 0, 700), (False, True), (0, 170))


def values_of(message: Message, chance: random.Random) -> dict[str, int]:
    """Every signal at an end of its range or between."""
    return {
        signal.name: chance.choice((0, 1, signal.most, chance.randrange(signal.most + 1)))
        for signal in message.signals
    }


@cache
def database() -> Any:
    cantools = pytest.importorskip("cantools")
    return cantools.database.load_string(dbc_text(), "dbc", strict=True)


def test_the_table_is_whole() -> None:
    assert len(BY_ID) == len({message.name for message in MESSAGES}) == len(MESSAGES)
    assert [message.id for message in MESSAGES] == sorted(BY_ID)
    assert max(BY_ID) < 0x800
    for message in MESSAGES:
        bits = [
            bit
            for signal in message.signals
            for bit in range(signal.start, signal.start + signal.length)
        ]
        assert len(bits) == len(set(bits)), message.name
        assert max(bits) < 8 * FRAME_BYTES
        for signal in message.signals:
            for choice in signal.choices or ():
                assert 0 <= choice <= signal.most


def test_every_unit_of_the_chips_is_some_raw_counts_long() -> None:
    """All but a BS2pe's 1.88 us are whole; the middle of a count has room for 50 ns either way."""
    units = {row.pulsin_unit_ns for row in CHIPS} | {row.rctime_unit_ns for row in CHIPS}
    assert {unit for unit in units if unit % TICK_NS} == {1_880}
    assert min(units) >= 10 * TICK_NS


@pytest.mark.parametrize("row", CHIPS, ids=lambda row: row.name)
def test_what_a_rig_presents_is_near_the_middle_of_a_count(row: Chip) -> None:
    for unit in (row.pulsin_unit_ns, row.rctime_unit_ns):
        for count in (1, 2, 7, 1_966, 24_666, 65_535):
            presented_ns = middle_ticks(count, unit) * TICK_NS
            assert abs(presented_ns - (count * unit + unit / 2)) <= TICK_NS
            assert count_of_ticks(middle_ticks(count, unit), unit) == count


def test_the_shipped_file_is_what_the_table_renders() -> None:
    assert DBC_FILE.read_text("ascii") == dbc_text()


@pytest.mark.parametrize("message", MESSAGES, ids=lambda one: one.name)
def test_cantools_reads_the_file_and_packs_the_same_bytes(message: Message) -> None:
    theirs = database().get_message_by_frame_id(message.id)
    assert (theirs.name, theirs.length, theirs.is_extended_frame) == (message.name, 8, False)
    assert theirs.senders == [message.sender]
    for one in message.signals:
        found = theirs.get_signal_by_name(one.name)
        assert (found.unit or "") == one.unit
        assert float(found.scale) == float(one.scale)
        assert float(found.maximum) == float(one.scale) * one.most
        named = {number: str(name) for number, name in (found.choices or {}).items()}
        assert named == {int(choice): choice.name for choice in one.choices or ()}
    chance = random.Random(message.id)
    for _ in range(50):
        values = values_of(message, chance)
        data = pack(message, values)
        assert theirs.encode(values, scaling=False) == data
        assert theirs.decode(data, scaling=False, decode_choices=False) == values
        scaled = theirs.decode(data, decode_choices=False)
        assert theirs.encode(scaled) == data


@pytest.mark.parametrize("message", MESSAGES, ids=lambda one: one.name)
def test_bytes_give_back_what_was_packed(message: Message) -> None:
    chance = random.Random(message.id)
    for _ in range(50):
        values = values_of(message, chance)
        assert unpack(message, pack(message, values)) == values


def test_the_protocol_explains_every_word() -> None:
    text = (DBC_FILE.parents[1] / "PROTOCOL.md").read_text("utf-8").partition("# The CAN")[2]
    ids: set[int] = set()
    for first, last in re.findall(r"^\| ([0-9A-F]{3})(?: to ([0-9A-F]{3}))? \| `", text, re.M):
        ids |= set(range(int(first, 16), int(last or first, 16) + 1))
    assert ids == set(BY_ID)
    signals = {signal.name for message in MESSAGES for signal in message.signals}
    told = {name for name in signals if not re.match(r"SONAR\d|LIGHT_|SERVO\d|WHISKER", name)}
    assert {name for name in told if f"`{name}`" not in text} == set()
    for words in (Op, State, Report):
        assert all(re.search(rf"\b{word.name}\b", text) for word in words if word.value), words
    assert all(f"{fault.value:04X}" in text for fault in Fault if fault & 0xFF == 0 < fault)


def test_values_without_room_are_refused() -> None:
    with pytest.raises(ValueError, match=r"RIG_CMD\.OP: 256 is not 0 to 255"):
        pack(RIG_CMD, {"OP": 256, "SEQ": 0, "ARG": 0})
    with pytest.raises(ValueError, match=r"RIG_CMD\.SEQ: -1"):
        pack(RIG_CMD, {"OP": 0, "SEQ": -1, "ARG": 0})
    with pytest.raises(ValueError, match="ARG: missing"):
        pack(RIG_CMD, {"OP": 0, "SEQ": 0})
    with pytest.raises(ValueError, match="XY: missing, or none"):
        frame(RIG_CMD, OP=Op.NOP, XY=1)
    with pytest.raises(ValueError, match="7 bytes, not 8"):
        unpack(RIG_CMD, bytes(7))


def test_a_predators_question_in_bytes() -> None:
    """By hand: 1843 counts of 0.75 us end in the middle of 1843 at 1382.6 us, 27652 raw counts."""
    sonar_a, sonar_b, light, apply = frames_of(READING, 0x1234, BS2P, Fault.TORN_R)
    assert sonar_a == Frame(0x100, bytes.fromhex("046c00 000000 3412"))
    assert sonar_b == Frame(0x101, bytes.fromhex("0b2900 000000 3412"))
    assert light == Frame(0x103, bytes.fromhex("000000 fd0900 3412"))
    assert apply == Frame(0x104, bytes.fromhex("02 07 0103 0000 3412"))


@given(
    sonars=st.lists(st.integers(0, 65_535), min_size=1, max_size=6),
    touched=st.tuples(st.booleans(), st.booleans()),
    lights=st.none() | st.tuples(st.integers(0, 65_535), st.integers(0, 65_535)),
    seq=st.integers(0, 65_535),
    units=st.sampled_from(
        [BS2P, Units(2_000, 2_000), Units(800, 750), Units(1_880, 2_000), Units(900, 868)]
    ),
)
def test_a_stimulus_comes_back_from_its_frames(
    sonars: list[int],
    touched: tuple[bool, bool],
    lights: tuple[int, int] | None,
    seq: int,
    units: Units,
) -> None:
    stimulus = Stimulus(tuple(sonars), touched, lights or ())
    frames = frames_of(stimulus, seq, units)
    assert stimulus_of(frames, units) == (seq, stimulus)
    assert question_frames(question_of(frames)) == frames


def test_the_frames_of_a_prey_need_no_light() -> None:
    frames = frames_of(Stimulus((1, 2, 3, 4, 5, 6)), 9, BS2P)
    assert [one.id for one in frames] == [0x100, 0x101, 0x102, 0x104]
    assert question_of(frames) == Question(9, (22, 37, 52, 67, 82, 97), (False, False))


def test_a_question_may_come_in_any_order() -> None:
    frames = frames_of(READING, 3, BS2P)
    for order in itertools.permutations(frames):
        assert stimulus_of(order, BS2P) == (3, READING)


def test_a_question_that_is_not_whole_is_refused() -> None:
    a, b, light, apply = frames_of(READING, 3, BS2P)
    other = frames_of(READING, 4, BS2P)
    for frames, why in (
        ((a, b, light), "STIM_APPLY is missing"),
        ((b, light, apply), "STIM_SONAR_A is missing"),
        ((a, light, apply), "STIM_SONAR_B is missing"),
        ((a, a, b, light, apply), "STIM_SONAR_A is there twice"),
        ((other[0], b, light, apply), "another question than 3"),
        ((a, b, frame(STIM_SONARS[2], SEQ=3), light, apply), "STIM_SONAR_C is of no sonar"),
        ((a, b, frame(OBS_DECISION), light, apply), "frame 200 is none of a question"),
        ((a, b, light, frame(STIM_APPLY, SONAR_MASK=5, SEQ=3)), "SONAR_MASK 000101"),
        ((a, b, light, frame(STIM_APPLY, SEQ=3)), "SONAR_MASK 000000"),
        ((a, b, Frame(STIM_LIGHT.id, light.data[:7]), apply), "7 bytes"),
    ):
        with pytest.raises(ValueError, match=why):
            question_of(frames)
    with pytest.raises(ValueError, match="7 sonars"):
        frames_of(Stimulus((0,) * 7), 0, BS2P)


def test_a_time_that_the_chip_cannot_measure_is_refused() -> None:
    frames = question_frames(Question(1, (65_536 * 16,), (False, False)))
    with pytest.raises(ValueError, match=r"52428\.8 us is longer than the chip can measure"):
        stimulus_of(frames, BS2P)
    shortest = question_frames(Question(1, (1,), (False, False)))
    assert stimulus_of(shortest, BS2P)[1].sonars == (1,)


@pytest.mark.parametrize(
    "answer",
    [Observation(65_535, 7, 63, latency_ns=1_234_550), Observation(0, 0), Observation(1, 3, 0)],
)
def test_an_answer_comes_back_from_its_frame(answer: Observation) -> None:
    assert decision_of(decision_frame(answer).data) == answer


def test_an_answer_that_is_not_valid_is_none() -> None:
    assert decision_of(frame(OBS_DECISION, SEQ=1, COMMAND=5).data) is None


def test_the_table_needs_no_can_package() -> None:
    """What packs is plain Python; cantools is for the DBC file alone."""
    import hil.frames
    import hil.messages

    for module in (hil.frames, hil.messages):
        spec = importlib.util.find_spec(module.__name__)
        assert spec is not None
        assert spec.origin is not None
        with open(spec.origin, encoding="utf-8") as file:
            words = [line.split()[1] for line in file if line.startswith(("import ", "from "))]
        assert not {"can", "cantools", "numpy"} & set(words)
