"""Between the readings of a trace and the frames of a rig."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

from cgagen.robot import Robot
from hil.frames import Frame, Units, decision_frame, decision_of, frames_of, stimulus_of
from hil.messages import (
    BY_ID,
    OBS_DECISION,
    RIG_CMD,
    SEQUENCES,
    STIM_APPLY,
    STIM_LIGHT,
    STIM_SONARS,
    Fault,
    unpack,
)
from hil.roster import trouble_of
from hil.target import Observation
from hil.traces.candump import Row
from hil.traces.values import (
    NS_PER_US,
    Sample,
    check_decision,
    refused,
)

QUESTION = {message.id for message in (*STIM_SONARS, STIM_LIGHT, STIM_APPLY)}


def frames_of_samples(samples: Iterable[Sample], robot: Robot) -> Iterator[tuple[int, Frame]]:
    """Return the frames of a trace with their microseconds.

    A decision's frame comes when the target had decided, by its own clock, but not later than
    the next reading.
    """
    units = Units.of(robot)
    decision: tuple[int, Frame] | None = None
    for sample in samples:
        time_us = sample.time_ns // NS_PER_US
        if decision is not None:
            yield min(decision[0], time_us), decision[1]
        for frame in frames_of(sample.stimulus, sample.seq, units):
            yield time_us, frame
        decision = None
        if sample.command is not None:
            seen = Observation(sample.seq, sample.command, sample.state, None, sample.latency_ns)
            latency_us = (sample.latency_ns or 0) // NS_PER_US
            decision = (time_us + latency_us, decision_frame(seen))
    if decision is not None:
        yield decision


class Reader:
    """Puts frames together to readings.

    Args:
        name: of the file.
        robot: whose chip measures.

    Attributes:
        samples: what was found.
        stale: decisions about earlier readings that came once more.
    """

    def __init__(self, name: str, robot: Robot) -> None:
        self.samples: list[Sample] = []
        self.stale = 0
        self._name = name
        self._robot = robot
        self._units = Units.of(robot)
        self._open: list[Frame] = []
        self._open_where = ""
        self._asked: set[int] = set()
        self._last: int | None = None
        self._answerable = -1
        self._first_us = self._last_us = 0

    def take(self, row: Row) -> None:
        """Take the next frame.

        Raises:
            TraceError: it does not fit what came before.
        """
        if row.time_us < self._last_us:
            back, forth = self._last_us / 1e6, row.time_us / 1e6
            raise refused(
                self._name, row.where, f"the time goes back from {back:.6f} s to {forth:.6f} s"
            )
        self._last_us = row.time_us
        if row.frame.id in QUESTION:
            self._question(row)
        elif row.frame.id == OBS_DECISION.id:
            self._decision(row)
        elif row.frame.id == RIG_CMD.id:  # a host counts commands and questions as one
            self._last = unpack(RIG_CMD, row.frame.data)["SEQ"]

    def end(self) -> None:
        """Say that no frame follows.

        Raises:
            TraceError: something is missing.
        """
        if self._open:
            raise refused(
                self._name,
                self._open_where,
                f"the file ends before {STIM_APPLY.name} of reading {self._open_seq}",
            )
        if not self.samples:
            raise refused(self._name, "", "holds no reading")

    def _question(self, row: Row) -> None:
        seq = unpack(BY_ID[row.frame.id], row.frame.data)["SEQ"]
        if self._open and seq != self._open_seq:
            raise refused(
                self._name,
                row.where,
                f"a frame of reading {seq} in the middle of reading {self._open_seq}, which has "
                f"no {STIM_APPLY.name} yet",
            )
        if not self._open:
            self._check_next(seq, row)
            self._open_seq = self._last = seq
            self._asked.add(seq)
        self._open.append(row.frame)
        self._open_where = row.where
        if row.frame.id == STIM_APPLY.id:
            self._apply(row)

    def _check_next(self, seq: int, row: Row) -> None:
        """Refuse a number that does not follow the last one, a command's or a reading's."""
        if self._last is None or seq == (self._last + 1) % SEQUENCES:
            return
        step = (seq - self._last) % SEQUENCES
        back = step == 0 or step >= SEQUENCES // 2
        what = f"the number goes back from {self._last} to {seq}"
        missing = f"reading {seq} follows {self._last}, and those between are missing"
        raise refused(self._name, row.where, what if back else missing)

    def _apply(self, row: Row) -> None:
        frames, self._open = self._open, []
        try:
            seq, stimulus = stimulus_of(frames, self._units)
        except ValueError as error:
            raise refused(self._name, row.where, str(error)) from error
        if unpack(STIM_APPLY, row.frame.data)["FAULT"] != Fault.NONE:
            raise refused(
                self._name,
                row.where,
                f"reading {seq} has a fault, which no other target can make",
                "record without faults",
            )
        odd = trouble_of(stimulus, self._robot)
        if odd:
            raise refused(self._name, row.where, f"reading {seq} {odd}", "name its own robot")
        self._answerable = seq
        self._first_us = self._first_us if self.samples else row.time_us
        time_ns = (row.time_us - self._first_us) * NS_PER_US
        number = (len(self.samples) + 1) % SEQUENCES
        self.samples.append(Sample(time_ns, stimulus, number, where=row.where))

    def _decision(self, row: Row) -> None:
        seq = unpack(OBS_DECISION, row.frame.data)["SEQ"]
        if seq not in self._asked or (self._open and seq == self._open_seq):
            raise refused(self._name, row.where, f"a decision about reading {seq}, which is none")
        if seq != self._answerable:
            self.stale += 1
            return
        seen = decision_of(row.frame.data)
        if seen is None:
            return
        last = self.samples[-1]
        if last.decided:
            raise refused(self._name, row.where, f"a second decision about reading {seq}")
        odd = check_decision(self._robot.role, seen.state, seen.command)
        if odd:
            raise refused(self._name, row.where, odd)
        self.samples[-1] = replace(
            last, state=seen.state, command=seen.command, latency_ns=seen.latency_ns
        )

    _open_seq: int = 0


def samples_of(rows: Iterable[Row], name: str, robot: Robot) -> tuple[tuple[Sample, ...], int]:
    """Return the readings in frames, and how many stale decisions were among them.

    Raises:
        TraceError: see `Reader`.
    """
    reader = Reader(name, robot)
    for row in rows:
        reader.take(row)
    reader.end()
    return tuple(reader.samples), reader.stale
