"""A genome: 64 commands as 192 bits, and the text file that holds it.

Gene 0 answers the state "no obstacle, no target"; the others follow `words.state_of`. Inside a
gene the most significant bit comes first, as the paper prints it (Ref: S1 figure 5).
"""

from cgagen.genome.text import FORMAT, load, parse, to_text
from cgagen.genome.value import (
    PAPER_ROBOT,
    Genome,
    Origin,
    Standing,
    check_interface,
    from_array,
    from_commands,
    movement_table,
    origin_text,
)

__all__ = [
    "FORMAT",
    "PAPER_ROBOT",
    "Genome",
    "Origin",
    "Standing",
    "check_interface",
    "from_array",
    "from_commands",
    "load",
    "movement_table",
    "origin_text",
    "parse",
    "to_text",
]
