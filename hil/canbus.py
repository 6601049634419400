"""A robot on a stimulus rig, over python-can: the target `can:INTERFACE:CHANNEL`.

The robot runs its own program; the rig stands in for its sensors and looks at its wires. So what
is tried is the program that walks. Its bytes cannot be seen that way: see `CanTarget.note`.
"""

from dataclasses import replace
from itertools import pairwise

from cgagen.bench_protocol import Banner, banner_in
from cgagen.errors import IdentityError, RigError
from cgagen.link.lock import PortLock
from hil.can_session import ANSWER_S, CanSession, Rig
from hil.frames import Units, decision_of, frames_of
from hil.guard import beside, is_clear
from hil.messages import OBS_SERVOS, SEQUENCES, TICK_NS, Fault, Op
from hil.rig_url import rig_url
from hil.roster import check_reading
from hil.subject import Subject
from hil.target import LATENCY, PINS, POWER, SERVOS, STATE, Identity, Observation, Stimulus

SERVO_FRAME_S = 0.06
"""How long one servo frame may take; servos go limp after 50 ms. Choice."""

ASK_AGAIN = 3
"""How often a question is asked of which frames were lost. Choice."""


class CanTarget:
    """A main controller behind a rig.

    Args:
        url: see `hil.rig_url`.
        subject: what is to be in the chips.

    Attributes:
        unheard: questions that had to be asked again.
        exact_image: False: a rig looks at pins, so no byte of the program is compared.
        guard_counts: how far readings keep from thresholds; the rest is left out.
        fired: whether the fault of the last question has made a difference; None without one.

    Raises:
        RigError: the URL is malformed.
    """

    exact_image = False

    def __init__(self, url: str, subject: Subject) -> None:
        self._place = rig_url(url)
        self.url = url
        self.unheard = 0
        self.guard_counts = self._place.guard_counts or 0
        self.fired: bool | None = None
        self.caps = frozenset({PINS, LATENCY})
        self._subject = subject
        self._units = Units.of(subject.robot)
        self._lock = PortLock(self._place.lock_name)
        self._session = CanSession(self._place, url)
        self._rig: Rig | None = None

    @property
    def stale(self) -> int:
        """Answers to earlier questions, and greetings that were not for us."""
        return self._session.stale

    @property
    def foreign(self) -> str:
        """What else was on the bus, in words."""
        return self._session.line.odd()

    def open(self) -> None:
        """Open the bus, greet the rig, and make sure that it is one for this robot.

        Raises:
            RigError: no adapter, no rig, or another one than is needed.
            IdentityError: another program is in the chip, by its own words.
        """
        self._lock.take()
        try:
            self._session.line.open()
            self._greet()
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Let the bus go. Harmless when repeated."""
        self._session.line.close()
        self._lock.release()

    def identity(self) -> Identity:
        """Return what the main controller has said of itself, where the rig has heard it.

        Raises:
            RigError: it is not open.
        """
        rig, wanted = self._known(), self._wanted()
        nonce = f"{rig.nonce:08x}"
        if wanted is None or rig.banner == (0, 0):
            return Identity("", "", nonce=nonce)
        return Identity(wanted.robot, f"{rig.banner[0]:08x}", nonce=nonce)

    @property
    def note(self) -> str:
        """What is known of the program in the chip, and how exact the rig is."""
        band = (
            f"; readings within {self.guard_counts} counts of a threshold, or of one another, are "
            "left out and UNPROVEN"
            if self.guard_counts
            else ""
        )
        if self._rig is None or self._rig.banner == (0, 0):
            words = "a rig sees no EEPROM, and this one heard no banner: the program is not known"
            return words + band
        genome, source = self._rig.banner
        return (
            f"a rig sees no EEPROM; by its own banner the program is of genome {genome:08x} and "
            f"source {source:08x}, as the build is{band}"
        )

    def admits(self, stimulus: Stimulus) -> bool:
        """Say whether a stimulus is clear of doubt with this rig's timers."""
        check_reading(stimulus, self._subject.robot)
        return is_clear(self._subject.robot, stimulus, self.guard_counts)

    def beside(self) -> list[Stimulus]:
        """Return the readings just outside of the guard band; none for a rig that is exact."""
        return beside(self._subject.robot, self.guard_counts) if self.guard_counts else []

    def reset(self) -> None:
        """Reset the robot, and greet the rig again.

        Raises:
            RigError: the rig cannot do so.
        """
        self._session.command(Op.RESET)
        self._greet()

    def power(self, on: bool) -> None:
        """Switch the robot's supply.

        Raises:
            RigError: the rig cannot do so.
        """
        if not self._known().values["SWITCHES_POWER"]:
            raise RigError(f"{self.url}: this rig cannot switch the supply; do it by hand")
        self._session.command(Op.POWER_ON if on else Op.POWER_OFF)

    def decide(self, stimulus: Stimulus, fault: int = Fault.NONE) -> Observation:
        """Have the rig present a stimulus, and return what the robot decides.

        Args:
            stimulus: in chip counts.
            fault: what the rig is to spoil meanwhile; then see `fired`.

        Raises:
            ReadingError: the stimulus is not one of this robot.
            TargetTimeout: the rig lives, and the robot does not decide.
            RigError: the rig is silent, refuses, or frames are lost again and again.
        """
        check_reading(stimulus, self._subject.robot)
        self.fired = None
        for _ in range(ASK_AGAIN):
            number = self._session.number()
            frames = frames_of(stimulus, number % SEQUENCES, self._units, fault)
            answer = self._session.ask(number, frames, f"the reading {stimulus.text()}")
            observation = decision_of(answer.data) if answer else None
            if answer and observation:
                self.fired = answer.fired
                return replace(observation, seq=answer.number)
            self.unheard += 1
        raise RigError(
            f"{self.url}: question or answer was lost {ASK_AGAIN} times in a row "
            f"({self.foreign}); look at the wiring and the load of the bus"
        )

    def servos(self, frames: int) -> list[tuple[int, ...]]:
        """Let the robot go on from its last decision and return its servos' pulses.

        Returns:
            By frame, the ns of each of the twelve pulses in the robot's order; 0 for none.

        Raises:
            RigError: the rig sees no servos, or frames were lost.
        """
        if not self._known().values["SEES_SERVOS"]:
            raise RigError(f"{self.url}: this rig does not see the servos")
        rows: dict[int, dict[int, dict[str, int]]] = {}
        wait_s = ANSWER_S + frames * SERVO_FRAME_S
        for came in self._session.command(Op.SERVOS, frames, wait_s):
            if came.message in OBS_SERVOS:
                row = rows.setdefault(came.values["FRAME"], {})
                row[came.message.id] = came.values
        follows = all((after - one) % SEQUENCES == 1 for one, after in pairwise(rows))
        if len(rows) != frames or not follows or any(len(row) != 4 for row in rows.values()):
            raise RigError(f"{self.url}: servo frames were lost on the bus; ask for them again")
        return [
            tuple(
                row[message.id][signal.name] * TICK_NS
                for message in OBS_SERVOS
                for signal in message.signals[:-1]
            )
            for row in rows.values()
        ]

    def _greet(self) -> None:
        rig = self._session.greet()
        robot, seen = self._subject.robot, rig.values
        lights = len(robot.light.sensors) if robot.light else 0
        if (seen["SONARS"], seen["LIGHTS"]) != (len(robot.sonars), lights):
            raise IdentityError(
                f"{self.url}: the rig has {seen['SONARS']} sonars and {seen['LIGHTS']} light "
                f"sensors, {robot.name} has {len(robot.sonars)} and {lights}; take that robot's rig"
            )
        wanted = self._wanted()
        if not seen["HEARS"]:
            rig = rig._replace(banner=(0, 0))
        can_show = {
            STATE: seen["HEARS"] and robot.telemetry,
            POWER: seen["SWITCHES_POWER"],
            SERVOS: seen["SEES_SERVOS"],
        }
        self.caps |= {word for word, able in can_show.items() if able}
        known = (int(wanted.genome, 16), int(wanted.source, 16)) if wanted else (0, 0)
        if rig.banner not in ((0, 0), known):
            raise IdentityError(
                f"{self.url}: the chip says genome {rig.banner[0]:08x}, source "
                f"{rig.banner[1]:08x}; the build has {known[0]:08x}, {known[1]:08x}, so load it"
            )
        if self._place.guard_counts is None:  # as far as the rig itself says
            self.guard_counts = -(-seen["JITTER"] * TICK_NS // min(self._units))
        self._rig = rig

    def _wanted(self) -> Banner | None:
        return banner_in(self._subject.images["main"].eeprom)

    def _known(self) -> Rig:
        if self._rig is None:
            raise RigError(f"{self.url}: is not open; open it first")
        return self._rig
