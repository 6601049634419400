"""The vocabulary: what a robot can do, what it can see, and the numbers of its states.

Everybody below speaks these words and no others: the simulator, the templates, the emulator
and the tests. The paper's two tables are here and nowhere else.
"""

from enum import IntEnum, StrEnum

GENES = 64
"""States of the predator, hence genes of a chromosome. Ref: S1 section III.A."""

BITS_PER_GENE = 3
"""Bits of a command. Ref: S1 table I."""

GENOME_BITS = GENES * BITS_PER_GENE


class Role(StrEnum):
    """Which of the two robots."""

    PREDATOR = "predator"
    PREY = "prey"


class Movement(StrEnum):
    """A gait cycle that a locomotion controller can be asked for. Ref: S1 table I."""

    FORWARD = "FORWARD"
    BACKWARD = "BACKWARD"
    WAIT = "WAIT"
    RIGHT_FORWARD = "RIGHT_FORWARD"
    LEFT_FORWARD = "LEFT_FORWARD"
    ROTATE_RIGHT = "ROTATE_RIGHT"
    ROTATE_LEFT = "ROTATE_LEFT"
    BACKUP_RIGHT = "BACKUP_RIGHT"
    BACKUP_LEFT = "BACKUP_LEFT"


def _table_one(second: Movement) -> tuple[Movement, ...]:
    return (
        Movement.FORWARD,
        second,
        Movement.RIGHT_FORWARD,
        Movement.LEFT_FORWARD,
        Movement.ROTATE_RIGHT,
        Movement.ROTATE_LEFT,
        Movement.BACKUP_RIGHT,
        Movement.BACKUP_LEFT,
    )


COMMANDS: dict[Role, tuple[Movement, ...]] = {
    Role.PREDATOR: _table_one(Movement.BACKWARD),
    Role.PREY: _table_one(Movement.WAIT),
}
"""Movement by 3-bit command, 000 to 111, for each robot. Ref: S1 table I."""


class Situation(IntEnum):
    """Where the nearest obstacle, or the target, stands. Ref: S1 table II, in its order."""

    NO = 0
    NEAR_RIGHT = 1
    FAR_RIGHT = 2
    NEAR_LEFT = 3
    FAR_LEFT = 4
    NEAR_FRONT = 5
    MIDDLE_FRONT = 6
    FAR_FRONT = 7


def state_of(obstacle: Situation, target: Situation) -> int:
    """Return the state, 0 to 63, which is also the index of the gene that answers it.

    Ref: S1 section III.A for gene 0; the order of the others is a choice (DECISIONS.md 2).

    >>> state_of(Situation.NO, Situation.NO)
    0
    >>> state_of(Situation.NEAR_RIGHT, Situation.FAR_FRONT)
    15
    """
    return 8 * obstacle + target


def situations_of(state: int) -> tuple[Situation, Situation]:
    """Return (obstacle, target) of a state: the inverse of `state_of`.

    Raises:
        ValueError: the state is not 0 to 63.

    >>> situations_of(15)
    (<Situation.NEAR_RIGHT: 1>, <Situation.FAR_FRONT: 7>)
    """
    if not 0 <= state < GENES:
        raise ValueError(f"state {state} is not one of 0 to {GENES - 1}")
    return Situation(state // 8), Situation(state % 8)


def situation_name(situation: Situation, what: str) -> str:
    """Return the situation as the paper writes it: `no_object`, `near_right`, ...

    Args:
        situation: one of the eight.
        what: what the NO situation lacks, "object" or "target".

    >>> situation_name(Situation.NO, "target"), situation_name(Situation.FAR_LEFT, "target")
    ('no_target', 'far_left')
    """
    return f"no_{what}" if situation is Situation.NO else situation.name.lower()
