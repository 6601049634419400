"""Durations of the buses that every chip of the BS2p family drives alike, in nanoseconds.

See `cgagen.emulator.timing` for what differs from model to model.
"""

from typing import NamedTuple

from cgagen.emulator.timing import MS, US


class OneWireTiming(NamedTuple):
    """One speed of the 1-Wire bus.

    Attributes:
        reset_low_ns: the master's reset pulse.
        presence_ns: from its end to the look at the presence pulse.
        reset_rest_ns: from there to the end of the reset slot.
        short_low_ns: low time that begins the slot of a 1, and a read slot.
        slot_ns: a slot; the master holds the line low for all of it to send a 0.
        sample_ns: from the beginning of a read slot to the look at the line.
        recovery_ns: high time between slots.
    """

    reset_low_ns: int
    presence_ns: int
    reset_rest_ns: int
    short_low_ns: int
    slot_ns: int
    sample_ns: int
    recovery_ns: int


ONE_WIRE = OneWireTiming(564 * US, 70 * US, 410 * US, 8 * US, 72 * US, 10 * US, 8 * US)
"""Normal speed. Ref: S2 p. 299, 300, 308 for the reset pulse, slots, recovery and the 1 to 10 us
in which a read slot is sampled, "approximate"; choice for presence and rest, which are inside the
limits of any 1-Wire part."""

ONE_WIRE_READ_LOW_NS = 4 * US
"""Low time that begins a read slot at normal speed. Ref: S2 p. 300."""

ONE_WIRE_FAST = OneWireTiming(70 * US, 8_500, 40 * US, US, 7_500, 2 * US, 2_500)
"""High speed. Ref: choice; the manual gives no times. They are usual for overdrive."""


class LcdTiming(NamedTuple):
    """The 4-bit bus of a display with an HD44780.

    Attributes:
        setup_ns: from data, RS and R/W to E high, and from E low to the next data.
        enable_ns: E high; what the display answers is read at its end.
        busy_ns: after each byte. Longer waits (clear, home, power-up) are the program's.
    """

    setup_ns: int
    enable_ns: int
    busy_ns: int


LCD = LcdTiming(US, US, 40 * US)
"""Ref: choice, inside the limits of an HD44780; the Stamp manual gives no times."""


class X10Timing(NamedTuple):
    """What goes out at a zero crossing of the mains.

    Attributes:
        burst_ns: one burst.
        spacing_ns: from one burst to the next: a sixth of a period of 60 Hz.
        bursts: for the three phases.
        gap_crossings: silence after a command that is not part of a series: three periods.
    """

    burst_ns: int
    spacing_ns: int
    bursts: int
    gap_crossings: int


X10 = X10Timing(MS, 2_778 * US, 3, 6)
"""Ref: X-10's transmission rules for the PL513 and TW523; that the Stamp sends all three bursts is
a choice."""
