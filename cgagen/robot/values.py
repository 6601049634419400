"""A robot and its arena as frozen values.

Units are in the names; angles are degrees from the heading, counter-clockwise positive; a
lateral displacement is positive to the right (DECISIONS.md 1).
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

from cgagen.counts import FARTHEST_COUNT, LightCurve, echo_count, light_count, light_curve
from cgagen.words import COMMANDS, Movement, Role

LEGS = ("LF", "LM", "LR", "RF", "RM", "RR")
"""Left front, left middle, ...: the order of masks, servos and DATA. Choice."""

SONARS: dict[Role, tuple[str, ...]] = {
    Role.PREDATOR: ("front", "right", "left"),
    Role.PREY: ("front_left", "front_right", "left", "right", "rear_left", "rear_right"),
}
"""The sonars of each robot, in the order in which a tie between them is decided. Ref: S1 II;
S1 I for the prey's front before middle before back; the rest is a choice (DECISIONS.md 5)."""

SIDES = ("left", "right")


class SonarKind(NamedTuple):
    """What the data sheet says of a kind of sonar."""

    shortest_us: float
    longest_us: float
    pins: tuple[str, ...]


SONAR_KINDS: dict[str, SonarKind] = {
    "ping": SonarKind(115.0, 18_500.0, ("pin",)),  # ref: S6 p. 1
    "srf04": SonarKind(174.0, 36_000.0, ("trigger_pin", "echo_pin")),  # ref: S8; 3 cm at 58 us
}

SLOW_MODELS = ("BS2", "BS2e", "BS2pe")
"""Models that may look at an SRF04's echo after it has begun, unless its mode pin is on ground: it
then waits 300 us longer. Ref: S8 p. 6 for a BS2; choice for the BS2pe, which is just in time."""

LAST_EARLY_PIN = 7
"""Where a slow model must have the echo of an SRF04 whose mode pin is open. Ref: S8 p. 6, "low"
numbers, for it takes longer to look at higher ones; choice for 7."""


@dataclass(frozen=True, slots=True)
class MainChip:
    """The main controller: its model and the units in which it measures."""

    model: str
    pulsin_unit_ns: int
    rctime_unit_ns: int
    pulsout_unit_ns: int


@dataclass(frozen=True, slots=True)
class LocomotionChip:
    """The locomotion controller."""

    model: str
    pulsout_unit_ns: int


@dataclass(frozen=True, slots=True)
class Echo:
    """How sound travels, and how and how often sonars are asked."""

    us_per_in: float
    trigger_us: float
    trigger_gap_ms: int


@dataclass(frozen=True, slots=True)
class Sonar:
    """One sonar.

    Attributes:
        pins: one (`ping`), or trigger and echo (`srf04`).
        mode: of an SRF04's mode pin, "ground" or "open"; "" where the file leaves it to us.
    """

    name: str
    kind: str
    bearing_deg: float
    cone_deg: float
    range_in: float
    pins: tuple[int, ...]
    mode: str = ""


@dataclass(frozen=True, slots=True)
class Antenna:
    """One touch antenna.

    The other robot bends it when its centre is within `length_in` and its bearing is within
    `robot_deg`.
    """

    name: str
    bearing_deg: float
    length_in: float
    robot_deg: tuple[float, float]
    pin: int


@dataclass(frozen=True, slots=True)
class LightSensor:
    """One tube-shielded photoresistor."""

    name: str
    bearing_deg: float
    cone_deg: float
    pin: int
    curve: tuple[tuple[float, int], ...]
    """What it counts with the lamp at a distance in inches; parts differ from piece to piece."""


@dataclass(frozen=True, slots=True)
class Light:
    """Both light sensors, their common circuit, and how far they see the lamp."""

    condition: str
    dark_range_in: float
    ambient_range_in: float
    capacitor_uf: float
    charge_ms: int
    sensors: tuple[LightSensor, ...]

    @property
    def range_in(self) -> float:
        """The range in the condition that the file names."""
        return self.dark_range_in if self.condition == "dark" else self.ambient_range_in


@dataclass(frozen=True, slots=True)
class SituationLimits:
    """Table II in inches, and whether a sonar that faces the lit target is ignored."""

    masking: bool
    front_near_in: float
    front_middle_in: float
    front_far_in: float
    side_near_in: float
    side_far_in: float
    target_front_near_in: float
    target_front_middle_in: float
    target_side_near_in: float


class LampCounts(NamedTuple):
    """What one light sensor counts with the lamp at each limit."""

    front_near: int
    front_middle: int
    side_near: int
    range: int


class SituationCounts(NamedTuple):
    """The same limits as the chip compares them: a reading is near when its count is less."""

    front_near: int
    front_middle: int
    front_far: int
    side_near: int
    side_far: int
    lamp_left: LampCounts
    lamp_right: LampCounts


@dataclass(frozen=True, slots=True)
class Policy:
    """What the prey does about the nearest of its sonars, in the order of `SONARS`."""

    alarm_in: float
    answers: tuple[Movement, ...]


@dataclass(frozen=True, slots=True)
class Reflex:
    """The prey's rule: antennas first, then the nearest sonar, else it waits."""

    policy_name: str
    policies: dict[str, Policy]
    antenna_left: Movement
    antenna_right: Movement
    both_left_open: Movement
    both_right_open: Movement

    @property
    def policy(self) -> Policy:
        """The policy that the file names."""
        return self.policies[self.policy_name]


@dataclass(frozen=True, slots=True)
class StepLine:
    """The fourth wire between the Stamps, by its pin on each."""

    main_pin: int
    locomotion_pin: int


@dataclass(frozen=True, slots=True)
class CommandLink:
    """The wires between the Stamps; bit 0 first. No step line: three lines, free-running."""

    main_pins: tuple[int, ...]
    locomotion_pins: tuple[int, ...]
    step_line: StepLine | None


@dataclass(frozen=True, slots=True)
class Step:
    """A movement as the arena sees it, and as the legs make it.

    Attributes:
        movement: which one.
        along_units: displacement along the heading before the step.
        right_units: displacement to the right of it.
        turn_deg: change of heading, counter-clockwise positive.
        order: "forward" or "reverse" walk of the gait's poses, or "hold".
        first_phase: 1 to 6; 0 for "hold".
        left_deg: swing of the left legs to either side; negative swings the other way.
        right_deg: of the right legs.
        frames: servo frames of a push, or of the whole of a "hold".
    """

    movement: Movement
    along_units: float
    right_units: float
    turn_deg: float
    order: str
    first_phase: int
    left_deg: float
    right_deg: float
    frames: int


@dataclass(frozen=True, slots=True)
class Pose:
    """One of the six poses of the gait: a flag per leg, in the order of `LEGS`."""

    up: tuple[bool, ...]
    forward: tuple[bool, ...]


@dataclass(frozen=True, slots=True)
class Gait:
    """The tripod gait."""

    lift_deg: float
    lift_frames: int
    lower_frames: int
    poses: tuple[Pose, ...]


@dataclass(frozen=True, slots=True)
class Servo:
    """One of the twelve: `joint` is "horizontal" or "vertical"."""

    leg: str
    joint: str
    pin: int
    direction: int
    trim_counts: int


@dataclass(frozen=True, slots=True)
class ServoSet:
    """All twelve, leg by leg in the order of `LEGS`, horizontal before vertical.

    `start_frames` is how many frames each leg is given, alone, when all are brought to the centre.
    """

    centre_counts: int
    counts_per_deg: float
    min_counts: int
    max_counts: int
    start_frames: int
    servos: tuple[Servo, ...]


@dataclass(frozen=True)
class Robot:
    """One robot. `text` is the file it came from, `digest` the SHA-256 of that."""

    name: str
    role: Role
    telemetry: bool
    main: MainChip
    locomotion: LocomotionChip
    body_radius_units: float
    echo: Echo
    sonars: tuple[Sonar, ...]
    antennas: tuple[Antenna, ...]
    light: Light | None
    limits: SituationLimits | None
    reflex: Reflex | None
    link: CommandLink
    steps: tuple[Step, ...]
    gait: Gait
    servo_set: ServoSet
    text: str = field(repr=False)
    digest: str

    @cached_property
    def interface(self) -> str:
        """What a genome depends on, in one line: sensors, situations, movements.

        A genome works on every robot with the same line, whatever its numbers are.
        """
        words = [f"sonar {' '.join(sonar.name for sonar in self.sonars)}"]
        words.append(f"antenna {' '.join(antenna.name for antenna in self.antennas)}")
        if self.light:
            words.append(f"light {' '.join(sensor.name for sensor in self.light.sensors)}")
        words.append("obstacle 8 x target 8" if self.limits else "reflex")
        words.append(" ".join(COMMANDS[self.role]))
        return "; ".join(words)

    @property
    def echo_counts_per_in(self) -> float:
        """PULSIN counts of an echo, there and back, per inch of distance."""
        return 2.0 * self.echo.us_per_in * 1000.0 / self.main.pulsin_unit_ns

    def echo_limits_counts(self, sonar: Sonar) -> tuple[float, float]:
        """Return the shortest and the longest echo of a sonar in counts, not rounded."""
        kind = SONAR_KINDS[sonar.kind]
        per_us = 1000.0 / self.main.pulsin_unit_ns
        return kind.shortest_us * per_us, kind.longest_us * per_us

    def grounds_mode(self, sonar: Sonar) -> bool:
        """Whether the mode pin of an SRF04 is on ground; see `SLOW_MODELS`."""
        if sonar.kind != "srf04":
            return False
        return sonar.mode == "ground" or (not sonar.mode and self.main.model in SLOW_MODELS)

    def echo_count_of(self, distance_in: float) -> int:
        """Return the count that stands for a threshold in inches, for any kind of sonar."""
        return echo_count(distance_in, self.echo_counts_per_in, 0.0, float(FARTHEST_COUNT))

    def light_curve(self, side: int, distance_scale: float = 1.0) -> LightCurve:
        """Return the curve of a light sensor with distances in inches times `distance_scale`.

        Args:
            side: which, by its number in `SIDES`.
            distance_scale: what an inch is in the unit that is wanted.

        Raises:
            ValueError: this robot has no light sensors.
        """
        if self.light is None:
            raise ValueError(f"{self.name} has no light sensors")
        return light_curve(list(self.light.sensors[side].curve), distance_scale)

    def _lamp_counts(self, side: int) -> LampCounts:
        """Return the lamp's limits in the counts of one sensor."""
        if self.limits is None or self.light is None:
            raise ValueError(f"{self.name} has no situations")
        curve = self.light_curve(side)
        return LampCounts(
            front_near=light_count(self.limits.target_front_near_in, curve),
            front_middle=light_count(self.limits.target_front_middle_in, curve),
            side_near=light_count(self.limits.target_side_near_in, curve),
            range=light_count(self.light.range_in, curve),
        )

    @cached_property
    def situation_counts(self) -> SituationCounts:
        """The limits of Table II in the counts of this robot's main controller.

        Raises:
            ValueError: this robot has no situations (a prey).
        """
        if self.limits is None or self.light is None:
            raise ValueError(f"{self.name} has no situations")
        limits = self.limits
        return SituationCounts(
            front_near=self.echo_count_of(limits.front_near_in),
            front_middle=self.echo_count_of(limits.front_middle_in),
            front_far=self.echo_count_of(limits.front_far_in),
            side_near=self.echo_count_of(limits.side_near_in),
            side_far=self.echo_count_of(limits.side_far_in),
            lamp_left=self._lamp_counts(0),
            lamp_right=self._lamp_counts(1),
        )

    @property
    def alarm_count(self) -> int:
        """The prey's alarm distance in counts.

        Raises:
            ValueError: this robot has no reflex (a predator).
        """
        if self.reflex is None:
            raise ValueError(f"{self.name} has no reflex")
        return self.echo_count_of(self.reflex.policy.alarm_in)


@dataclass(frozen=True, slots=True)
class Arena:
    """The square that both robots walk in."""

    name: str
    side_units: float
    units_per_in: float
    longest_units: float
    capture_score_units: float
    start_gap_units: float
    walls: str
    after_capture: str
    text: str = field(repr=False)
    digest: str
