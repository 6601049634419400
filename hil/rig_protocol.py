"""The emulated rig: frames in, frames out, no bus. What it does stands in PROTOCOL.md.

Its clock is the robot's, so the same questions get the same frames, in every run.
"""

from collections.abc import Generator, Iterator

from cgagen.errors import CgagenError, TargetTimeout
from hil.emulated import DECISION_LIMIT_NS
from hil.frames import Frame, Question, frame, question_of
from hil.messages import (
    BY_ID,
    FRAME_BYTES,
    OBS_DECISION,
    OBS_SERVOS,
    RIG_BANNER,
    RIG_CMD,
    RIG_IDENTITY,
    RIG_STATUS,
    SEQUENCES,
    STIM_LIGHT,
    STIM_SONARS,
    TICK_NS,
    VERSION,
    Message,
    Op,
    Report,
    State,
    unpack,
)
from hil.rig_robot import RigRobot
from hil.subject import Subject

MOST_SERVO_FRAMES = 500
"""That one RIG_CMD may ask for: some 12 s of the robot's time. Choice."""

_STIMULI = {message.id for message in (*STIM_SONARS, STIM_LIGHT)}


class Rig:
    """An emulated robot that is asked by CAN messages.

    Args:
        subject: what is in its chips.

    Attributes:
        jitter_ticks: what it says of its timers.
    """

    jitter_ticks = 0

    def __init__(self, subject: Subject) -> None:
        self.robot = RigRobot(subject)
        self._parts: dict[int, Frame] = {}
        self._parts_seq = 0
        self._answered: int | None = None
        self._taken_seq = 0
        self._state = State.OFF
        self._hangs = False
        self._elapsed_ns = 0
        self._servo_frame = 0

    def open(self) -> None:
        """Switch the robot on.

        Raises:
            RigError: the emulator refuses the bench.
        """
        self._answered, self._parts, self._hangs = None, {}, False
        try:
            self.robot.open()
        except TargetTimeout:
            self._hangs = True  # a fault of the program: no question will be answered
        self._state = State.IDLE
        self._elapsed_ns += self.robot.bench.clock.now_ns

    def close(self) -> None:
        """Switch it off."""
        self.robot.close()
        self._state = State.OFF

    @property
    def time_ms(self) -> int:
        """How long the robot has been on in all, by its own clock."""
        return self._elapsed_ns // 1_000_000

    def heartbeat(self) -> Frame:
        """Return what says that the rig lives."""
        return self._status(self._taken_seq)

    def receive(self, given: Frame) -> Iterator[Frame]:
        """Take a frame from the bus; return what the rig answers, as it comes about."""
        try:
            yield from self._receive(given)
        except CgagenError:
            self._state = State.FAULT
            yield self._status(self._taken_seq, Report.SICK)

    # -- One frame ----------------------------------------------------------------------------

    def _receive(self, given: Frame) -> Iterator[Frame]:
        message = BY_ID.get(given.id)
        if message is None or message.sender == RIG_STATUS.sender:
            return
        if len(given.data) != FRAME_BYTES:
            yield self._status(self._taken_seq, Report.BAD_FRAME)
            return
        values = unpack(message, given.data)
        if message is RIG_CMD:
            yield from self._command(values["OP"], values["SEQ"], values["ARG"])
        elif given.id in _STIMULI:
            yield from self._take(message, given, values["SEQ"])
        else:
            yield from self._apply(given, values["SEQ"])

    def _take(self, message: Message, given: Frame, seq: int) -> Iterator[Frame]:
        """Keep a frame of a question until STIM_APPLY comes; a new number drops older frames."""
        if not self._is_new(seq):
            yield self._status(seq, Report.OLD_SEQ)
            return
        if seq != self._parts_seq:
            self._parts, self._parts_seq = {}, seq
        self._parts[message.id] = given
        if self._state is State.IDLE:
            self._state = State.ARMED

    def _apply(self, given: Frame, seq: int) -> Iterator[Frame]:
        if not self._is_new(seq):
            yield self._status(seq, Report.OLD_SEQ)
            return
        parts = self._parts.values() if seq == self._parts_seq else ()
        try:
            question = question_of([*parts, given])
        except ValueError:
            yield self._status(seq, Report.INCOMPLETE)
            return
        refused = self._refusal(question)
        if refused:
            yield self._status(seq, refused)
            return
        yield from self._answer(question)

    def _refusal(self, question: Question) -> Report:
        robot = self.robot.subject.robot
        sensors = (len(robot.sonars), len(robot.light.sensors) if robot.light else 0)
        if self._state in (State.OFF, State.FAULT):
            return Report.NO_POWER if self._state is State.OFF else Report.SICK
        if (len(question.echoes), len(question.drains)) != sensors:
            return Report.BAD_FRAME
        if question.fault and question.fault not in self.robot.faults:
            return Report.UNKNOWN_FAULT
        return Report.NONE

    def _answer(self, question: Question) -> Iterator[Frame]:
        seq = question.seq
        self._parts, self._answered, self._taken_seq = {}, seq, seq
        self._state = State.RUNNING
        yield self._status(seq)
        seen = None if self._hangs else self.robot.answer(question)
        self._elapsed_ns += seen[1] if seen else DECISION_LIMIT_NS
        if question.fault:
            fired = self.robot.fired(question.fault)
            yield self._status(seq, Report.FAULT_FIRED if fired else Report.FAULT_SILENT)
        yield self._decision(seq, seen)
        self._state = State.IDLE
        yield self._status(seq, Report.NONE if seen else Report.NO_DECISION)

    def _decision(self, seq: int, seen: tuple[int, int] | None) -> Frame:
        if seen is None:
            return frame(OBS_DECISION, SEQ=seq)
        told = self.robot.told()
        return frame(
            OBS_DECISION,
            COMMAND=seen[0],
            VALID=1,
            STATE_VALID=int(told is not None),
            STATE=told.state if told else 0,
            SEQ=seq,
            LATENCY=seen[1] // TICK_NS,
        )

    # -- Commands -----------------------------------------------------------------------------

    def _command(self, op: int, seq: int, argument: int) -> Iterator[Frame]:
        self._taken_seq, report = seq, Report.NONE
        if op == Op.HELLO:
            self._answered, self._parts = None, {}
            self._state = State.IDLE if self._state is State.ARMED else self._state
            yield from self._who(argument)
        elif op in (Op.RESET, Op.POWER_ON):
            if op == Op.RESET and self._state is State.OFF:
                report = Report.NO_POWER
            else:
                self.open()
        elif op == Op.POWER_OFF:
            self.close()
        elif op == Op.SERVOS:
            report = yield from self._servos(seq, argument)
        elif op != Op.NOP:
            report = Report.BAD_FRAME
        yield self._status(seq, report)

    def _who(self, nonce: int) -> Iterator[Frame]:
        robot = self.robot.subject.robot
        yield frame(
            RIG_IDENTITY,
            NONCE=nonce,
            PROTOCOL=VERSION,
            SONARS=len(robot.sonars),
            LIGHTS=len(robot.light.sensors) if robot.light else 0,
            HEARS=1,
            SWITCHES_POWER=1,
            SEES_SERVOS=1,
            JITTER=self.jitter_ticks,
        )
        said = self.robot.banner
        words = (int(said.genome, 16), int(said.source, 16)) if said else (0, 0)
        yield frame(RIG_BANNER, GENOME=words[0], SOURCE=words[1])

    def _servos(self, seq: int, frames: int) -> Generator[Frame, None, Report]:
        """Let the robot walk on and show its servos' pulses."""
        if self._state is State.OFF:
            return Report.NO_POWER
        if not 1 <= frames <= MOST_SERVO_FRAMES:
            return Report.BAD_FRAME
        if self._hangs or self._answered is None:
            return Report.NO_SERVOS
        self._state = State.RUNNING
        yield self._status(seq)
        before_ns = self.robot.bench.clock.now_ns
        taken = self.robot.walk(frames)
        self._elapsed_ns += self.robot.bench.clock.now_ns - before_ns
        for pulses in taken:
            yield from self._servo_frames(pulses)
        self._state = State.IDLE
        return Report.NONE if len(taken) == frames else Report.NO_SERVOS

    def _servo_frames(self, pulses: tuple[int, ...]) -> Iterator[Frame]:
        number = self._servo_frame
        self._servo_frame = (number + 1) % SEQUENCES
        for first, message in enumerate(OBS_SERVOS):
            names = [signal.name for signal in message.signals[:-1]]
            three = pulses[3 * first : 3 * first + 3]
            ticks = [min(width_ns // TICK_NS, 0xFFFF) for width_ns in three]
            yield frame(message, FRAME=number, **dict(zip(names, ticks, strict=True)))

    # -- Little helpers -----------------------------------------------------------------------

    def _is_new(self, seq: int) -> bool:
        """Say whether a number comes after the last answered one, counted around the end."""
        if self._answered is None:
            return True
        return 0 < (seq - self._answered) % SEQUENCES < SEQUENCES // 2

    def _status(self, seq: int, report: Report = Report.NONE) -> Frame:
        return frame(
            RIG_STATUS,
            STATE=self._state,
            SEQ=seq,
            ERROR=report,
            RIG_TIME_MS=self.time_ms & 0xFFFFFFFF,
        )
