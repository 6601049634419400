"""A photoresistor and a capacitor in parallel to ground, behind a series resistor. Ref: S2 p. 363.

The pin charges the capacitor; when the pin becomes an input, the capacitor drains through the
photoresistor, the faster the brighter, and the pin reads 1 until the threshold.

Left out: the photoresistor's load while charging (2 % of the voltage at 10 kohm), leakage, the
tolerance of the capacitor, and how long a photoresistor takes to follow the light.
"""

import math

from cgagen.emulator.clock import Clock
from cgagen.emulator.parts.part import Part
from cgagen.emulator.wires import Strength, Wire

SERIES_OHM = 220.0
"""Ref: S2 p. 363."""
THRESHOLD = 1.4 / 5.0
"""Of the supply. Ref: S4 (COUNT) 1.4 V; S9 says about 1.5 V."""
SMALLEST = 1e-9
"""Part of the supply below which the capacitor counts as empty, or as full. Choice."""


class Photocell(Part):
    """A light sensor for RCTIME.

    Args:
        name: as the bench calls it.
        clock: the bench's.
        signal: the wire on the pin.
        capacitor_uf: the capacitor.

    >>> cell = Photocell("left", Clock(), Wire("left"), 0.01)
    >>> cell.light(10_000); cell.drain_ns
    127296
    """

    def __init__(self, name: str, clock: Clock, signal: Wire, capacitor_uf: float) -> None:
        super().__init__(name, clock)
        self._signal = signal
        self._capacitor_f = capacitor_uf * 1e-6
        self._drain_ns: int | None = None
        self._charge = 0.0
        self._since_ns = clock.now_ns
        self._held: int | None = None
        self._falls = self.timer(self._fallen)
        signal.drive(name, 0, Strength.RESISTOR)
        signal.watch(self._changed)

    @property
    def drain_ns(self) -> int | None:
        """From full to the threshold; None for never: dark."""
        return self._drain_ns

    @property
    def charge(self) -> float:
        """Voltage of the capacitor now, as a part of the supply."""
        passed_ns = self.clock.now_ns - self._since_ns
        if self._held is None:
            if self._drain_ns is None:
                return self._charge
            left = self._charge * math.exp(math.log(THRESHOLD) * passed_ns / self._drain_ns)
            return left if left > SMALLEST else 0.0
        missing = (self._held - self._charge) * math.exp(
            -passed_ns * 1e-9 / (SERIES_OHM * self._capacitor_f)
        )
        return self._held - missing if abs(missing) > SMALLEST else float(self._held)

    def light(self, resistance_ohm: float | None) -> None:
        """Say what the photoresistor has in the present light; None for no end of it: dark."""
        if resistance_ohm is None:
            self.drain(None)
        else:
            seconds = resistance_ohm * self._capacitor_f * -math.log(THRESHOLD)
            self.drain(int(seconds * 1e9))

    def drain(self, drain_ns: int | None) -> None:
        """Say how long the capacitor takes from full to the threshold; None for ever."""
        self._settle()
        self._drain_ns = None if drain_ns is None else max(drain_ns, 1)
        self._show()

    def _changed(self) -> None:
        held = self._signal.output
        if held != self._held:
            self._settle()
            self._held = held
            self._show()

    def _settle(self) -> None:
        """Take the present charge as the beginning of what comes."""
        self._charge, self._since_ns = self.charge, self.clock.now_ns

    def _show(self) -> None:
        """Hold the wire where the capacitor is, and book when it falls below the threshold."""
        self._falls.cancel()
        high = self._charge > THRESHOLD
        if high and self._held is None and self._drain_ns is not None:
            part = 1.0 - math.log(self._charge) / math.log(THRESHOLD)
            self._falls.after(round(self._drain_ns * part))
        self._signal.drive(self.name, int(high), Strength.RESISTOR)

    def _fallen(self) -> None:
        self._charge, self._since_ns = THRESHOLD, self.clock.now_ns
        self._signal.drive(self.name, 0, Strength.RESISTOR)
