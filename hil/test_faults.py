"""What a robot does when a part of it fails. Every fault shows that it made a difference."""

import pytest

from cgagen.build.bench import bench_text
from cgagen.emulator.parts.fault import Fault
from cgagen.emulator.parts.servo import Servo
from cgagen.words import Situation, state_of
from hil.lone import Lone
from hil.lone_cases import subject
from hil.target import Stimulus

pytestmark = pytest.mark.hil_req("FAULTS")

AHEAD = Stimulus((1_000, 9_000, 9_000), lights=(0, 0))
"""A wall before the predator."""

LIT_AHEAD = Stimulus((1_000, 9_000, 9_000), lights=(200, 200))
"""The prey before it."""

OPEN = Stimulus((24_665,) * 3, lights=(0, 0))


def gene(state: int) -> int:
    genome = subject("predator").genome
    assert genome is not None
    return int(genome.bits[3 * state : 3 * state + 3], 2)


def faulty(stimulus: Stimulus, *faults: str, name: str = "predator") -> Lone:
    """A robot with faults, each the lines of its table."""
    text = bench_text(subject(name).robot)
    for number, fault in enumerate(faults):
        text += f"\n[fault.f{number}]\n{fault}\n"
    lone = Lone(subject(name), text)
    lone.show(stimulus)
    return lone


def fired(lone: Lone) -> list[int]:
    return [fault.fired for fault in lone.bench.parts_of(Fault).values()]


def decided(lone: Lone) -> tuple[int, int]:
    """The state that the telemetry says, and the movement that the legs make."""
    walk = lone.walk()
    assert walk is not None
    assert walk.made.command is not None, walk.made.reason
    assert lone.player.said is not None
    return lone.player.said.state, walk.made.command


def test_without_a_fault_the_same_robots_do_what_the_genome_says() -> None:
    near = state_of(Situation.NEAR_FRONT, Situation.NO)
    lit = state_of(Situation.NO, Situation.NEAR_FRONT)
    assert decided(faulty(AHEAD)) == (near, gene(near))
    assert decided(faulty(LIT_AHEAD)) == (lit, gene(lit))


def test_a_dead_sonar_sees_nothing_and_says_so() -> None:
    """It counts 0, is farther than everything, and the wall before it is not seen."""
    lone = faulty(AHEAD, 'kind = "no_echo"\npart = "sonar_front"')
    assert decided(lone) == (0, gene(0))
    assert lone.player.said is not None
    assert lone.player.said.stimulus.sonars == (0, 9_000, 9_000)
    assert fired(lone)[0] >= 1


STUCK = 'kind = "stuck_echo"\npart = "sonar_{}"'


def test_a_stuck_sonar_is_an_obstacle_for_ever_and_its_telemetry_shows_it() -> None:
    """0.85 ms are 5.8 in, whatever is there: the genome's answer to a wall ahead, each time."""
    near = state_of(Situation.NEAR_FRONT, Situation.NO)
    lone = faulty(OPEN, STUCK.format("front"))
    counts = set()
    for _ in range(3):
        assert decided(lone) == (near, gene(near))
        assert lone.player.said is not None
        counts.add(lone.player.said.stimulus.sonars[0])
    assert counts == {850_000 // subject("predator").robot.main.pulsin_unit_ns}
    assert fired(lone)[0] >= 3


def test_a_stuck_sonar_beside_the_prey_is_masked_by_its_light() -> None:
    """Where the lamp is, the sonar is not believed; the fault is then not noticed."""
    lone = faulty(Stimulus((9_000,) * 3, lights=(200, 200)), STUCK.format("front"))
    assert decided(lone)[0] == state_of(Situation.NO, Situation.NEAR_FRONT)
    assert fired(lone)[0] >= 1


@pytest.mark.parametrize("place", range(6))
def test_a_stuck_sonar_keeps_the_prey_from_resting(place: int) -> None:
    robot = subject("prey").robot
    lone = faulty(Stimulus((24_665,) * 6), STUCK.format(robot.sonars[place].name), name="prey")
    assert decided(lone)[0] == 1 + place
    assert fired(lone)[0] >= 1


def test_all_sonars_of_the_prey_dead_and_it_waits() -> None:
    names = [sonar.name for sonar in subject("prey").robot.sonars]
    faults = [f'kind = "no_echo"\npart = "sonar_{name}"' for name in names]
    lone = faulty(Stimulus((1_000,) * 6), *faults, name="prey")
    assert decided(lone) == (0, 1)
    assert min(fired(lone)) >= 1


@pytest.mark.parametrize(
    ("pin", "situation"), [(8, Situation.NEAR_LEFT), (9, Situation.NEAR_RIGHT)]
)
def test_a_stuck_antenna_is_an_obstacle_for_ever(pin: int, situation: Situation) -> None:
    """Touch comes before sound: whatever the sonars see, the genome's answer to touch is given."""
    state = state_of(situation, Situation.NO)
    for stimulus in (OPEN, AHEAD):
        lone = faulty(stimulus, f'kind = "stuck"\nend = "main.P{pin}"\nlevel = 0')
        assert decided(lone) == (state, gene(state))
        assert fired(lone)[0] >= 1


def test_a_torn_antenna_touches_nothing() -> None:
    touched = Stimulus(OPEN.sonars, (True, False), (0, 0))
    lone = faulty(touched, 'kind = "stuck"\nend = "main.P8"\nlevel = 1')
    assert decided(lone) == (0, gene(0))
    assert fired(lone)[0] >= 1


def test_a_dark_bulb_makes_an_obstacle_of_the_prey() -> None:
    """Neither capacitor drains: no target, so nothing is masked and the prey is a wall."""
    stuck = 'kind = "stuck"\nend = "main.P{}"\nlevel = 1'
    lone = faulty(LIT_AHEAD, stuck.format(10), stuck.format(11))
    near = state_of(Situation.NEAR_FRONT, Situation.NO)
    assert decided(lone) == (near, gene(near))
    assert lone.player.said is not None
    assert lone.player.said.stimulus.lights == (0, 0)
    assert min(fired(lone)) >= 1


def test_one_dark_sensor_puts_the_prey_to_the_other_side() -> None:
    lone = faulty(LIT_AHEAD, 'kind = "stuck"\nend = "main.P10"\nlevel = 1')
    state = state_of(Situation.NO, Situation.NEAR_RIGHT)
    assert decided(lone)[0] % 8 == state % 8
    assert fired(lone)[0] >= 1


@pytest.mark.parametrize("bit", [0, 1, 2])
def test_a_cut_command_wire_reads_as_zero(bit: int) -> None:
    """The wrong movement is made, always the same one, and the robot does not notice."""
    pin = subject("predator").robot.link.locomotion_pins[bit]
    state = next(
        state_of(s, Situation.NO) for s in Situation if gene(state_of(s, Situation.NO)) >> bit & 1
    )
    lone = faulty(stimulus_for(state), f'kind = "open"\nend = "locomotion.P{pin}"')
    seen, made = decided(lone)
    assert seen == state
    assert made == gene(state) & ~(1 << bit)
    assert fired(lone)[0] >= 1


def stimulus_for(state: int) -> Stimulus:
    """A reading for an obstacle without a target."""
    near, middle, far, away = 1_000, 3_000, 5_000, 9_000
    counts = {
        Situation.NO: (away, away, away),
        Situation.NEAR_RIGHT: (away, near, away),
        Situation.FAR_RIGHT: (away, far, away),
        Situation.NEAR_LEFT: (away, away, near),
        Situation.FAR_LEFT: (away, away, far),
        Situation.NEAR_FRONT: (near, away, away),
        Situation.MIDDLE_FRONT: (middle, away, away),
        Situation.FAR_FRONT: (far, away, away),
    }
    return Stimulus(counts[Situation(state // 8)], lights=(0, 0))


def test_a_cut_step_line_stops_the_robot() -> None:
    """Nobody takes a GO: the main controller hears a refusal each time, the legs stand."""
    pin = subject("predator").robot.link.locomotion_pins
    line = subject("predator").robot.link.step_line
    assert line is not None
    assert line.locomotion_pin not in pin
    lone = faulty(OPEN, f'kind = "open"\nend = "locomotion.P{line.locomotion_pin}"')
    lone.run(5_000)
    assert lone.walks == []
    assert lone.player.heard.count("*REFUSED") >= 3
    assert fired(lone)[0] >= 1
    assert all(not servo.limp for servo in lone.bench.parts_of(Servo).values())


def test_a_frozen_locomotion_controller_stops_the_robot_and_lets_its_legs_go_limp() -> None:
    """From 5 s on it does nothing: no movement, no pulse; the main controller reports it."""
    lone = faulty(OPEN, 'kind = "brown_out"\nchips = ["locomotion"]\nfrom_ms = 5000')
    lone.run(4_999)
    before = len(lone.walks)
    assert before >= 1
    assert "*REFUSED" not in lone.player.heard
    lone.run(4_001)
    assert fired(lone) == [1]
    assert [walk.made.command for walk in lone.walks[before:]] in ([], [None])  # cut short
    assert lone.player.heard.count("*REFUSED") >= 3
    assert all(servo.limp for servo in lone.bench.parts_of(Servo).values())


def test_a_locomotion_controller_that_comes_back_is_told_anew() -> None:
    fault = 'kind = "brown_out"\nchips = ["locomotion"]\nfrom_ms = 5000\nuntil_ms = 6000'
    lone = faulty(OPEN, fault)
    lone.run(5_500)
    walks, lone.booting = len(lone.walks), True  # it will centre the legs first
    lone.run(6_000)
    made = [walk.made.command for walk in lone.walks[walks:]]
    assert made == [gene(0)] * len(made)
    assert len(made) >= 2
    assert lone.uncommanded == []
    assert fired(lone) == [1]


def test_a_frozen_main_controller_stops_the_robot_with_its_legs_held() -> None:
    lone = faulty(OPEN, 'kind = "brown_out"\nchips = ["main"]\nfrom_ms = 3000')
    lone.run(6_000)
    walks = len(lone.walks)
    lone.run(10_000)
    assert len(lone.walks) == walks
    assert "*IDLE" in lone.words["locomotion"]
    assert fired(lone) == [1]
    assert all(not servo.limp for servo in lone.bench.parts_of(Servo).values())
