"""Between what a target is asked and answers, and the frames of a rig.

A rig presents the middle of a chip's count, in raw counts of 50 ns, so that no rounding decides
what the chip measures; the way back gives the very count.
"""

from collections.abc import Iterable
from typing import NamedTuple, Self

from cgagen.robot import Robot
from hil.messages import (
    BY_ID,
    LIGHTS,
    OBS_DECISION,
    SONARS,
    STIM_APPLY,
    STIM_LIGHT,
    STIM_SONARS,
    TICK_NS,
    Fault,
    Message,
    pack,
    unpack,
)
from hil.target import Observation, Stimulus

MOST_COUNT = 0xFFFF


class Frame(NamedTuple):
    """A frame on the bus."""

    id: int
    data: bytes


class Units(NamedTuple):
    """What one count of the main controller is."""

    pulsin_ns: int
    rctime_ns: int

    @classmethod
    def of(cls, robot: Robot) -> Self:
        """Return a robot's."""
        return cls(robot.main.pulsin_unit_ns, robot.main.rctime_unit_ns)


class Question(NamedTuple):
    """What the frames of one question say, in raw counts.

    Attributes:
        seq: its number.
        echoes: one for each sonar; 0 for no echo.
        touched: left and right.
        drains: left and right, 0 for dark; none for a robot without light sensors.
        fault: what is spoiled.
    """

    seq: int
    echoes: tuple[int, ...]
    touched: tuple[bool, bool]
    drains: tuple[int, ...] = ()
    fault: int = Fault.NONE


def middle_ticks(count: int, unit_ns: int) -> int:
    """Return the middle of a chip's count in raw counts; 0 for 0.

    >>> middle_ticks(1, 800), middle_ticks(1, 750), middle_ticks(0, 800)
    (24, 22, 0)
    """
    return (count * unit_ns + unit_ns // 2) // TICK_NS if count else 0


def count_of_ticks(ticks: int, unit_ns: int) -> int:
    """Return what a chip counts for so many raw counts; it counts 1 at least.

    Raises:
        ValueError: longer than the chip can measure.

    >>> count_of_ticks(24, 800), count_of_ticks(3, 800), count_of_ticks(0, 800)
    (1, 1, 0)
    """
    count = ticks * TICK_NS // unit_ns
    if count > MOST_COUNT:
        raise ValueError(f"{ticks * TICK_NS / 1_000:g} us is longer than the chip can measure")
    return max(count, 1) if ticks else 0


def frame(message: Message, **values: int) -> Frame:
    """Return a message as a frame, all other signals 0.

    Raises:
        ValueError: an unknown signal, or a value without room.

    >>> frame(STIM_APPLY, SEQ=5, SONAR_MASK=7).data.hex()
    '0007000000000500'
    """
    zeros = {signal.name: 0 for signal in message.signals}
    return Frame(message.id, pack(message, zeros | values))


def frames_of(
    stimulus: Stimulus, seq: int, units: Units, fault: int = Fault.NONE
) -> tuple[Frame, ...]:
    """Return the frames that apply a stimulus, in the order in which they are sent.

    Args:
        stimulus: in chip counts.
        seq: number of the question, 0 to 65,535.
        units: of the chip's counts.
        fault: what the rig is to spoil.

    Raises:
        ValueError: more sensors than the messages have room for.
    """
    drains = tuple(middle_ticks(count, units.rctime_ns) for count in stimulus.lights)
    echoes = tuple(middle_ticks(count, units.pulsin_ns) for count in stimulus.sonars)
    return question_frames(Question(seq, echoes, stimulus.touched, drains, fault))


def question_frames(question: Question) -> tuple[Frame, ...]:
    """Return the frames of a question in raw counts. See `frames_of`."""
    echoes, drains = question.echoes, question.drains
    if not 1 <= len(echoes) <= SONARS or len(drains) not in (0, LIGHTS):
        raise ValueError(f"{len(echoes)} sonars, {len(drains)} lights: the messages have no room")
    sonars = ((*echoes, 0)[2 * n : 2 * n + 2] for n in range((len(echoes) + 1) // 2))
    frames = [
        Frame(message.id, _filled(message, pair, question.seq))
        for message, pair in zip(STIM_SONARS, sonars, strict=False)
    ]
    if drains:
        frames.append(Frame(STIM_LIGHT.id, _filled(STIM_LIGHT, drains, question.seq)))
    left, right = question.touched
    apply = frame(
        STIM_APPLY,
        WHISKER_L=int(left),
        WHISKER_R=int(right),
        SONAR_MASK=(1 << len(echoes)) - 1,
        FAULT=question.fault,
        SEQ=question.seq,
    )
    return (*frames, apply)


def question_of(frames: Iterable[Frame]) -> Question:
    """Return what the frames of one question say; the last of them is STIM_APPLY.

    Raises:
        ValueError: a frame is missing, odd, of another number, or there twice.
    """
    found: dict[int, dict[str, int]] = {}
    for one in frames:
        message = BY_ID.get(one.id)
        if message is None or message not in (*STIM_SONARS, STIM_LIGHT, STIM_APPLY):
            raise ValueError(f"frame {one.id:03X} is none of a question")
        if message.id in found:
            raise ValueError(f"{message.name} is there twice")
        found[message.id] = unpack(message, one.data)
    apply = found.pop(STIM_APPLY.id, None)
    if apply is None:
        raise ValueError(f"{STIM_APPLY.name} is missing")
    seq = apply["SEQ"]
    if any(values["SEQ"] != seq for values in found.values()):
        raise ValueError(f"frames of another question than {seq}")
    echoes = _echoes(found, apply["SONAR_MASK"])
    light = found.pop(STIM_LIGHT.id, None)
    if found:
        raise ValueError(f"{BY_ID[min(found)].name} is of no sonar in SONAR_MASK")
    drains = (light["LIGHT_L_RC"], light["LIGHT_R_RC"]) if light else ()
    touched = (bool(apply["WHISKER_L"]), bool(apply["WHISKER_R"]))
    return Question(seq, echoes, touched, drains, apply["FAULT"])


def stimulus_of(frames: Iterable[Frame], units: Units) -> tuple[int, Stimulus]:
    """Return the number of a question and its stimulus: the inverse of `frames_of`.

    Raises:
        ValueError: see `question_of`; or a time that the chip cannot measure.

    >>> units, reading = Units(800, 750), Stimulus((1843, 0, 700), (False, True), (0, 170))
    >>> stimulus_of(frames_of(reading, 7, units), units) == (7, reading)
    True
    """
    question = question_of(frames)
    sonars = tuple(count_of_ticks(ticks, units.pulsin_ns) for ticks in question.echoes)
    lights = tuple(count_of_ticks(ticks, units.rctime_ns) for ticks in question.drains)
    return question.seq, Stimulus(sonars, question.touched, lights)


def decision_frame(observation: Observation) -> Frame:
    """Return an answer as a frame; what is not seen is not valid in it."""
    latency_ns, state = observation.latency_ns, observation.state
    return frame(
        OBS_DECISION,
        COMMAND=observation.command,
        VALID=1,
        STATE_VALID=int(state is not None),
        STATE=state or 0,
        SEQ=observation.seq,
        LATENCY=(latency_ns or 0) // TICK_NS,
    )


def decision_of(data: bytes) -> Observation | None:
    """Return what OBS_DECISION says; None where it says that there was no decision.

    Raises:
        ValueError: there are not 8 bytes.
    """
    values = unpack(OBS_DECISION, data)
    if not values["VALID"]:
        return None
    return Observation(
        values["SEQ"],
        values["COMMAND"],
        values["STATE"] if values["STATE_VALID"] else None,
        latency_ns=values["LATENCY"] * TICK_NS or None,
    )


def _filled(message: Message, times: tuple[int, ...], seq: int) -> bytes:
    names = [signal.name for signal in message.signals[:-1]]
    padded = (*times, *(0 for _ in range(len(names) - len(times))))
    return pack(message, dict(zip(names, padded, strict=True)) | {"SEQ": seq})


def _echoes(found: dict[int, dict[str, int]], mask: int) -> tuple[int, ...]:
    """Take the frames of the sonars out of what was found."""
    count = mask.bit_length()
    if not mask or mask != (1 << count) - 1:
        raise ValueError(f"SONAR_MASK {mask:06b} is not that of the first sonars")
    echoes: list[int] = []
    for message in STIM_SONARS[: (count + 1) // 2]:
        values = found.pop(message.id, None)
        if values is None:
            raise ValueError(f"{message.name} is missing")
        echoes += [values[signal.name] for signal in message.signals[:-1]]
    return tuple(echoes[:count])
