"""Waveforms: wires over time as VCD, for GTKWave, PulseView, sigrok-cli and any other viewer.

Times are in nanoseconds, and no date is in the file: equal runs give equal bytes. Numbers are
written as reals because sigrok's reader (libsigrok 0.5.2) gives up at a vector; measured.
"""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

from cgagen.closing import Closing
from cgagen.emulator.clock import Clock
from cgagen.emulator.wires import Wire
from cgagen.errors import BenchError
from cgagen.files import text_stream
from cgagen.outputs import Kind

if TYPE_CHECKING:
    from vcd.writer import Variable

WAVEFORM = Kind("a waveform", lambda head: b"$version cgagen $end" in head[:1000])

NO_SCOPE = "wires"
"""Where names without a dot go."""


class Waveform(Closing):
    """What happens on some wires from now on, written down as it happens.

    Args:
        file: open for writing; it stays open.
        clock: of the bench.
        wires: by name; "main.SOUT" becomes SOUT in the scope main, and main_SOUT there where
            another scope has a SOUT: decoders go by the short name alone.
        numbers: names of numbers that `set` will give, likewise.

    >>> import io
    >>> clock, wire, file = Clock(), Wire("led"), io.StringIO()
    >>> with Waveform(file, clock, {"led": wire}):
    ...     clock.run_until(5); wire.drive("x", 1)
    >>> file.getvalue().splitlines()[-2:]
    ['#5', '1!']
    """

    def __init__(
        self, file: TextIO, clock: Clock, wires: Mapping[str, Wire], numbers: Sequence[str] = ()
    ) -> None:
        from vcd import VCDWriter

        self._clock = clock
        self._newest_ns = clock.now_ns
        self._ahead_ns = 0
        self._writer = VCDWriter(
            file, timescale="1 ns", date="", version="cgagen", init_timestamp=clock.now_ns
        )
        self._stops = []
        self._wires: list[tuple[Wire, Variable[Any]]] = []
        places = _places([*wires, *numbers])
        for name, wire in wires.items():
            variable = self._writer.register_var(*places[name], "wire", 1, _shown(wire.level))
            self._stops.append(wire.listen(self._listener(variable)))
            self._wires.append((wire, variable))
        self._numbers = {
            name: self._writer.register_var(*places[name], "real", init=0.0) for name in numbers
        }

    def set(self, name: str, value: int) -> None:
        """Change a number now.

        Raises:
            BenchError: the bench has gone back in time since the last change.
        """
        self._change(self._numbers[name], float(value))

    def rejoin(self, left_ns: int) -> None:
        """Go on behind what is written, after the bench was put back to another moment.

        The file's time runs on while the bench's begins again there. For `Bench.on_restore`.

        Args:
            left_ns: the bench's time before.
        """
        self._newest_ns = max(self._newest_ns, left_ns + self._ahead_ns)
        self._ahead_ns = self._newest_ns - self._clock.now_ns
        for wire, variable in self._wires:
            self._change(variable, _shown(wire.level))

    def close(self) -> None:
        """Write the present time as the end. Harmless when repeated."""
        for stop in self._stops:
            stop()
        self._stops.clear()
        self._writer.close(max(self._clock.now_ns + self._ahead_ns, self._newest_ns))

    def _listener(self, variable: "Variable[Any]") -> "_Listener":
        return _Listener(self, variable)

    def _change(self, variable: "Variable[Any]", value: float | str) -> None:
        now_ns = self._clock.now_ns + self._ahead_ns
        if now_ns < self._newest_ns:
            raise BenchError(
                f"the bench went back to {now_ns} ns while a waveform was at {self._newest_ns} "
                "ns; close the waveform before a restore, or rejoin it behind"
            )
        self._newest_ns = now_ns
        self._writer.change(variable, now_ns, value)


class _Listener:
    __slots__ = ("_variable", "_waveform")

    def __init__(self, waveform: Waveform, variable: "Variable[Any]") -> None:
        self._waveform = waveform
        self._variable = variable

    def __call__(self, level: int | None) -> None:
        self._waveform._change(self._variable, _shown(level))


@contextmanager
def waveform_file(
    path: Path, clock: Clock, wires: Mapping[str, Wire], numbers: Sequence[str] = ()
) -> Iterator[Waveform]:
    """Write a waveform to a file, which takes its name when it is whole.

    Where the run ends in an error, the file has everything up to there: what led to a short
    circuit is what one wants to see.

    Args:
        path: of the file.
        clock: see `Waveform`.
        wires: likewise.
        numbers: likewise.

    Raises:
        StorageError: the disk is full, read-only or gone.
    """
    with text_stream(path) as file, Waveform(file, clock, wires, numbers) as waveform:
        yield waveform


def _places(names: Sequence[str]) -> dict[str, tuple[str, str]]:
    """Return scope and short name of each.

    >>> _places(["main.SOUT", "legs.SOUT", "main.SIN", "led"])["legs.SOUT"]
    ('legs', 'legs_SOUT')
    """
    parts = {name: name.rpartition(".") for name in names}
    shorts = Counter(short for _, _, short in parts.values())
    return {
        name: (scope or NO_SCOPE, short if shorts[short] == 1 else name.replace(".", "_"))
        for name, (scope, _, short) in parts.items()
    }


def _shown(level: int | None) -> int | str:
    return "z" if level is None else level
