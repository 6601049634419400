"""What the programmer says of adapters that lack a line, with an emulated Stamp behind them."""

import pytest

from cgagen.emulator.host_port import HostPort
from cgagen.emulator.programs import bench_of_image
from cgagen.errors import RigError
from cgagen.flash.line import Line
from cgagen.flash.programmer import ask
from cgagen.tokenizer import Tokenizer

HEADER = "' {$STAMP BS2}\n' {$PBASIC 2.5}\n"
SILENT = HEADER + "END\n"
TALKS = HEADER + 'DO\n  DEBUG "hello "\n  PAUSE 300\nLOOP\n'
BABBLES = HEADER + 'DO\n  DEBUG "hello "\nLOOP\n'


class WithoutBreak(HostPort):
    """An adapter that takes BREAK and does not send it, as some cheap ones."""

    @property
    def break_condition(self) -> bool:
        return False

    @break_condition.setter
    def break_condition(self, on: bool) -> None:
        pass


class WithoutDtr(HostPort):
    """An adapter with three wires, or a cable without DTR."""

    @property
    def dtr(self) -> bool:
        return False

    @dtr.setter
    def dtr(self, on: bool) -> None:
        pass


@pytest.mark.parametrize(
    ("adapter", "program", "words"),
    [
        (WithoutBreak, SILENT, r"neither BREAK nor an answer .*\(the echo comes and no answer"),
        (WithoutBreak, TALKS, r"neither BREAK nor an answer .*take an adapter that carries BREAK"),
        (WithoutBreak, BABBLES, "or BREAK does not; .*which must have DTR and BREAK"),
        (WithoutDtr, SILENT, "the Stamp is silent; .*the wire from DTR to ATN"),
        (WithoutDtr, TALKS, "no Stamp gives .*the wire from DTR to ATN"),
        (WithoutDtr, BABBLES, "goes on talking .*the wire from DTR to ATN"),
    ],
)
def test_an_adapter_that_lacks_a_line(
    tokenizer: Tokenizer, adapter: type[HostPort], program: str, words: str
) -> None:
    port = adapter(bench_of_image(tokenizer.compile(program, "x").image), timeout=0.05)
    port.sleep(1)
    with pytest.raises(RigError, match=words):
        ask(Line(port, port), "COM")
