"""From counts to a command: the predator's 64 states, and the prey's reflex.

Integers only, compared in the order of the paper's rules. Nothing in this file knows where the
counts come from; sonar counts have passed through `heard`.
"""

from cgagen.counts import FARTHEST_COUNT
from cgagen.robot import SituationCounts
from sim.jit import device
from sim.numbers import ReflexNumbers


@device
def heard(count: int) -> int:
    """Return a sonar count for comparison: 0, no echo, is farther than everything."""
    return FARTHEST_COUNT if count == 0 else count


@device
def lit(count: int, target_range: int) -> bool:
    """Say whether a light count means that the lamp is in sight."""
    return (count >= 1) & (count < target_range)


@device
def target_situation(light_left: int, light_right: int, limits: SituationCounts) -> int:
    """Return where the target stands, 0 to 7 in the order of Table II.

    Both lit: ahead, and the sensor that has it nearer, each by its own limits, decides how far. One
    lit: to that side. Ref: S1 II.B; the limits are a choice (DECISIONS.md 5).
    """
    by_left, by_right = limits.lamp_left, limits.lamp_right
    left = lit(light_left, by_left.range)
    right = lit(light_right, by_right.range)
    is_middle = (light_left < by_left.front_middle) | (light_right < by_right.front_middle)
    is_near = (light_left < by_left.front_near) | (light_right < by_right.front_near)
    middle = 6 if is_middle else 7
    ahead = 5 if is_near else middle
    to_left = 3 if light_left < by_left.side_near else 4
    to_right = 1 if light_right < by_right.side_near else 2
    one = to_left if left else (to_right if right else 0)
    return ahead if left & right else one


@device
def obstacle_situation(
    front: int,
    right: int,
    left: int,
    touch_left: bool,
    touch_right: bool,
    lit_left: bool,
    lit_right: bool,
    masking: bool,
    limits: SituationCounts,
) -> int:
    """Return where the nearest obstacle stands, 0 to 7 in the order of Table II.

    Antennas first; then the least count among the sonars that do not face the lit target, ties
    in the order front, right, left. Ref: S1 II.B; the limits, the masking and the order of ties
    are a choice (DECISIONS.md 5).
    """
    mask_right = masking & lit_right
    mask_left = masking & lit_left
    front = FARTHEST_COUNT if mask_left | mask_right else front
    right = FARTHEST_COUNT if mask_right else right
    left = FARTHEST_COUNT if mask_left else left
    ahead = (
        5
        if front < limits.front_near
        else (6 if front < limits.front_middle else (7 if front < limits.front_far else 0))
    )
    to_right = 1 if right < limits.side_near else (2 if right < limits.side_far else 0)
    to_left = 3 if left < limits.side_near else (4 if left < limits.side_far else 0)
    by_sonar = (
        ahead if (front <= right) & (front <= left) else (to_right if right <= left else to_left)
    )
    by_touch = 5 if touch_left & touch_right else (3 if touch_left else 1)
    return by_touch if touch_left | touch_right else by_sonar


@device
def gene(state: int, word: int) -> bool:
    """Return one bit of the command of a state.

    A genome is three words: bit n of word b is bit b of the command of state n. So there is no
    table to look up and the lanes stay together.
    """
    return ((word >> state) & 1) != 0


@device
def prey_command(
    front_left: int,
    front_right: int,
    left: int,
    right: int,
    rear_left: int,
    rear_right: int,
    touch_left: bool,
    touch_right: bool,
    reflex: ReflexNumbers,
) -> int:
    """Return what the prey does. Ref: S1 I and II.A; the rule is a choice (DECISIONS.md 7)."""
    least = front_left
    answer = reflex.answers[0]
    answer = reflex.answers[1] if front_right < least else answer
    least = front_right if front_right < least else least
    answer = reflex.answers[2] if left < least else answer
    least = left if left < least else least
    answer = reflex.answers[3] if right < least else answer
    least = right if right < least else least
    answer = reflex.answers[4] if rear_left < least else answer
    least = rear_left if rear_left < least else least
    answer = reflex.answers[5] if rear_right < least else answer
    least = rear_right if rear_right < least else least
    answer = answer if least < reflex.alarm else reflex.wait
    both = reflex.both_left_open if left > right else reflex.both_right_open
    answer = reflex.antenna_right if touch_right else answer
    answer = reflex.antenna_left if touch_left else answer
    return both if touch_left & touch_right else answer
