"""`--baud`: how a terminal listens and speaks."""

from typing import Any

import click

from cgagen.stamp.serial_mode import FASTEST_BAUD, SLOWEST_BAUD, SerialMode, parse_mode


class BaudType(click.ParamType[SerialMode]):
    """Bits per second, and -7E1 behind them for seven bits and even parity."""

    name = "MODE"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> SerialMode:
        """Return the mode, or a usage error."""
        mode = value if isinstance(value, SerialMode) else parse_mode(str(value))
        if mode is None:
            self.fail(
                f"{value!r} is no rate; give {SLOWEST_BAUD} to {FASTEST_BAUD} bits per second, "
                "and -7E1 behind it for seven bits and even parity: 2400 or 2400-7E1",
                param,
                ctx,
            )
        return mode
