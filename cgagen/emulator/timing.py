"""Every duration and unit of the chips, in one place.

The interpreter reads a bit-packed program from a serial EEPROM. Its time is modelled as::

    fetch_ns + bits * bit_ns + jump_ns for a jump that is taken + operations + time at the pins

The model is ours: four numbers, fitted by least squares of relative errors to seven published
times of a BS2 (FIDELITY.md; `tests/published_times.py` repeats the fit), which it meets within
6 %. What was not among them is good for +-10 %, with slow operators +-40 %. Of a BS2e two times
are published, HIGH 145 us and GOTO 285 us (Ref: S7): within 4 % of a BS2's, so it has the same
numbers. No other model was measured: theirs are the BS2's by the ratio of instructions per second
(Ref: S2, tables of models).
Units of instructions with pins are the manual's; where a row names no tolerance, neither does
the manual, and the chip's resonator decides.

A laboratory that has measured its own chip calibrates with `dataclasses.replace`:

>>> from dataclasses import replace
>>> from cgagen.stamp.chips import chip
>>> mine = replace(timing_of(chip("BS2")), fetch_ns=21_000)
"""

from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

from cgagen.stamp.chips import Chip

US = 1_000
MS = 1_000_000


@dataclass(frozen=True, slots=True)
class Timing:
    """One chip's durations, in nanoseconds.

    Attributes:
        fetch_ns: every instruction, before its bits. BS2 18.6 us. Ref: fit, see above.
        bit_ns: every bit of an instruction. BS2 8.05 us. Ref: fit, see above.
        jump_ns: every jump that is taken: the EEPROM is addressed anew. BS2 102.9 us.
            Ref: fit, see above.
        pause_setup_ns: PAUSE, besides its bits and its pause. BS2 59.2 us. Ref: fit, see above.
        simple_ns: + - & | ^ ~ shifts MIN MAX ABS NCD DCD REV and comparisons. BS2 3 us.
            Ref: choice, +-40 %.
        multiply_ns: * ** */. BS2 50 us. Ref: choice, +-40 %.
        divide_ns: / // DIG. BS2 90 us. Ref: choice, +-40 %.
        root_ns: SQR HYP ATN. BS2 150 us. Ref: choice, +-40 %.
        sine_ns: SIN COS. BS2 50 us. Ref: choice, +-40 %.
        read_ns: READ, besides its bits: one random access. BS2 100 us. Ref: choice, +-40 %.
        write_ns: WRITE, besides its bits: the EEPROM burns a byte. 5 ms. Ref: S2 p. 461 says
            "several milliseconds"; choice, 2 to 10 ms.
        slow_clock_ns: what SLEEP, END and POLLWAIT count in: 2.304 s. Ref: S2 p. 441, +-1 %
            for SLEEP.
        nap_ns: NAP 0, doubled by each step. 18 ms. Ref: S2 p. 285, -50 % to +100 %;
            S9 (1.8) p. 285, within 10 % at room temperature.
        glitch_ns: pins are inputs so long at each wake-up of END, NAP, SLEEP and POLLWAIT.
            18 ms, 60 us on a BS2pe. Ref: S2 p. 187, 286, 442.
        pollwait_ns: POLLWAIT 8 looks so often: 160 us, 250 us on a BS2pe. Ref: S2 p. 335 ("less
            than").
        pause_ns: one unit of PAUSE: 1 ms. Ref: S2 PAUSE, +-1 %.
        pulsout_ns: one unit of PULSOUT. Ref: S2 p. 347, exact but for the resonator.
        pulsout_glitch_ns: PULSOUT shows the latch of a pin that was an input so long before its
            pulse. 4 us. Ref: choice for "a few microseconds" in S9 (1.8) p. 291.
        pulsin_ns: one unit of PULSIN. Ref: S2 p. 343; a BS2p and a BS2pe as `Chip` has them.
        rctime_ns: one unit of RCTIME. Ref: S2 p. 363; for a BS2p S9 (2.0c) says 900, not 750.
        count_ns: one unit of COUNT's duration. BS2 1 ms, BS2sx 400 us, BS2p 287 us, BS2pe
            720 us. Ref: S2 p. 149, "approximate"; S9 (2.0c) p. 89; S5.
        count_pulse_ns: the shortest half of a pulse that COUNT sees. Ref: S2 p. 149.
        pwm_ns: one cycle of PWM. BS2 1 ms, BS2p 1 ms / 1.53, BS2pe 1.62 ms. Ref: S5 and S4 (PWM).
            S7 measured 1.15 ms on a BS2.
        freqout_ns: one unit of FREQOUT's duration. BS2 1 ms, BS2p 0.265 ms. Ref: S2 p. 199.
        freqout_millihertz: one unit of FREQOUT's frequency. BS2 1 Hz, BS2p 3.77 Hz, BS2pe
            1.51 Hz. Ref: S2 p. 199.
        dtmf_on_ns: one unit of DTMFOUT's on time. As FREQOUT's. Ref: S2 p. 179.
        dtmf_off_ns: one unit of DTMFOUT's off time: 1 ms. Ref: S2 p. 179.
        serin_timeout_ns: one unit of SERIN's time-out. BS2 1 ms, BS2p 0.4 ms. Ref: S2 p. 394.
        serout_timeout_ns: one unit of SEROUT's time-out. BS2 1 ms, BS2p 0.4 ms. Ref: S2 p. 416.
        serout_pace_ns: one unit of SEROUT's pace: 1 ms. Ref: S2 p. 416.
        serial_unit_ns: what a baud word counts in: bit time = (bits 0 to 12 + 20) units. 1 us,
            0.4 us on BS2sx and BS2p. Ref: S2 p. 419, 431.
        shift_high_ns: clock high time of SHIFTIN and SHIFTOUT. BS2 14 us, BS2p 5.6 us.
            Ref: S2 p. 435.
        shift_low_ns: clock low time of them. BS2 46 us, BS2p 18 us. Ref: S2 p. 435.
        shift_setup_ns: from the first clock low to the first bit, and from there to the first
            clock high. BS2 15 us, BS2p 6.3 us. Ref: S2 p. 435 (t_a).
        shift_hold_ns: from clock low to the next bit. BS2 30 us, BS2p 12.5 us. Ref: S2 p. 435.
        i2c_bit_ns: one bit of I2CIN and I2COUT. BS2p 81 kbit/s, BS2pe 45 kbit/s. Ref: S2 p. 218.
    """

    fetch_ns: int
    bit_ns: int
    jump_ns: int
    pause_setup_ns: int
    simple_ns: int
    multiply_ns: int
    divide_ns: int
    root_ns: int
    sine_ns: int
    read_ns: int
    write_ns: int
    slow_clock_ns: int
    nap_ns: int
    glitch_ns: int
    pollwait_ns: int
    pause_ns: int
    pulsout_ns: int
    pulsout_glitch_ns: int
    pulsin_ns: int
    rctime_ns: int
    count_ns: int
    count_pulse_ns: int
    pwm_ns: int
    freqout_ns: int
    freqout_millihertz: int
    dtmf_on_ns: int
    dtmf_off_ns: int
    serin_timeout_ns: int
    serout_timeout_ns: int
    serout_pace_ns: int
    serial_unit_ns: int
    shift_high_ns: int
    shift_low_ns: int
    shift_setup_ns: int
    shift_hold_ns: int
    i2c_bit_ns: int

    def operator_ns(self, code: int) -> int:
        """Return what an operator takes, by its code in `cgagen.stamp.opcodes`."""
        name = _SLOW.get(code, "simple_ns")
        result: int = getattr(self, name)
        return result


_SLOW = {
    **dict.fromkeys((0x11, 0x12, 0x13), "multiply_ns"),  # */ * **
    **dict.fromkeys((0x14, 0x15, 0x16), "divide_ns"),  # // / DIG
    **dict.fromkeys((0x00, 0x08, 0x09), "root_ns"),  # SQR HYP ATN
    **dict.fromkeys((0x06, 0x07), "sine_ns"),  # COS SIN
}

INSTRUCTIONS_PER_S = {"BS2": 4000, "BS2e": 4000, "BS2sx": 10000, "BS2p": 12000, "BS2pe": 6000}
"""Ref: S2, the table of models: they scale what the interpreter does itself."""

_FIT_US = {
    # of a BS2; see Timing
    "fetch_ns": 18.6,
    "bit_ns": 8.05,
    "jump_ns": 102.9,
    "pause_setup_ns": 59.2,
    "simple_ns": 3,
    "multiply_ns": 50,
    "divide_ns": 90,
    "root_ns": 150,
    "sine_ns": 50,
    "read_ns": 100,
}

_SLOW_UNITS = {  # BS2, BS2e, BS2pe
    "count_ns": MS,
    "count_pulse_ns": 4_160,
    "pwm_ns": MS,
    "freqout_ns": MS,
    "freqout_millihertz": 1_000,
    "dtmf_on_ns": MS,
    "serin_timeout_ns": MS,
    "serout_timeout_ns": MS,
    "serial_unit_ns": US,
    "shift_high_ns": 14 * US,
    "shift_low_ns": 46 * US,
    "shift_setup_ns": 15 * US,
    "shift_hold_ns": 30 * US,
    "i2c_bit_ns": 22_222,
}
_SX_UNITS = {  # the same instruction loops, 2.5 times as fast: Ref: S5 (its conditional constants)
    **_SLOW_UNITS,
    "count_ns": 400 * US,
    "count_pulse_ns": 1_660,
    "pwm_ns": 400 * US,
    "freqout_ns": 400 * US,
    "freqout_millihertz": 2_500,
    "dtmf_on_ns": 400 * US,
    "serin_timeout_ns": 400 * US,
    "serout_timeout_ns": 400 * US,
    "serial_unit_ns": 400,
    "shift_high_ns": 5_600,
    "shift_low_ns": 18 * US,
    "shift_setup_ns": 6_300,
    "shift_hold_ns": 12_500,
    "i2c_bit_ns": 12_346,
}
_P_UNITS = {
    **_SX_UNITS,
    "count_ns": 287 * US,
    "count_pulse_ns": 1_200,
    "pwm_ns": 653_595,
    "freqout_ns": 265 * US,
    "freqout_millihertz": 3_770,
    "dtmf_on_ns": 265 * US,
}
_UNITS = {
    "BS2": _SLOW_UNITS,
    "BS2e": _SLOW_UNITS,
    "BS2sx": _SX_UNITS,
    "BS2p": _P_UNITS,
    "BS2pe": {
        **_SLOW_UNITS,
        "count_ns": 720 * US,
        "count_pulse_ns": 3 * US,
        "pwm_ns": 1_620 * US,
        "freqout_millihertz": 1_510,
    },
}


@cache
def timing_of(model: Chip) -> Timing:
    """Return the durations of a model.

    >>> from cgagen.stamp.chips import chip
    >>> timing_of(chip("BS2")).fetch_ns, timing_of(chip("BS2p")).fetch_ns
    (18600, 6200)
    """
    rate = INSTRUCTIONS_PER_S[model.name]
    interpreter = {
        name: round(us * US * INSTRUCTIONS_PER_S["BS2"] / rate) for name, us in _FIT_US.items()
    }
    return Timing(
        **interpreter,
        **_UNITS[model.name],
        write_ns=5 * MS,
        slow_clock_ns=2_304 * MS,
        nap_ns=18 * MS,
        glitch_ns=60 * US if model.name == "BS2pe" else 18 * MS,
        pollwait_ns=(250 if model.name == "BS2pe" else 160) * US,
        pause_ns=MS,
        pulsout_ns=model.pulsout_unit_ns,
        pulsout_glitch_ns=4 * US,
        pulsin_ns=model.pulsin_unit_ns,
        rctime_ns=model.rctime_unit_ns,
        serout_pace_ns=MS,
        dtmf_off_ns=MS,
    )


# -- Buses, which every chip that has them drives alike ---------------------------------------


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
