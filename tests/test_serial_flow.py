"""Two Stamps with a flow pin between them lose nothing, on every model and at every rate.

Ref: S2 p. 394 (19,200 baud at most on each model) and p. 410 (with it communication is flawless).
"""

import itertools
from pathlib import Path

import pytest

from cgagen.emulator.bench_file import parse_bench
from cgagen.stamp.chips import CHIPS, chip
from cgagen.tokenizer import Tokenizer

TEXT = "ABCDEFGH"
RATES = (300, 1200, 2400, 4800, 9600, 19200)
UNIT_NS = {"BS2": 1000, "BS2e": 1000, "BS2pe": 1000, "BS2sx": 400, "BS2p": 400}
"""One unit of a baud word. Ref: S2 p. 419."""

SEVEN, INVERTED, OPEN = 0x2000, 0x4000, 0x8000

ITEMS = ", ".join(f"seen({place})" for place in range(8))

RECEIVERS = {
    # S2 p. 410: it takes a byte, works, and takes the next.
    "one by one": "FOR turn = 1 TO 8 : SERIN 4\\5, {word}, [seen(turn - 1)] : PAUSE 3 : NEXT",
    "a list": "SERIN 4\\5, {word}, [STR seen\\8]",
    "items": "SERIN 4\\5, {word}, [{items}]",
    "with a time-out": "FOR turn = 0 TO 7\nSERIN 4\\5, {word}, 1000, late, [seen(turn)]\nNEXT",
}


def word_of(model: str, rate: int) -> int:
    """Return the baud word of a rate (Ref: S2 p. 419)."""
    return round(1e9 / rate / UNIT_NS[model]) - 20


def received(tokenizer: Tokenizer, sender: str, taker: str, rate: int, mode: int, how: str) -> str:
    """Let one Stamp send to another; return what the other has."""
    takes = RECEIVERS[how].format(word=word_of(taker, rate) | mode, items=ITEMS)
    head = "' {{$STAMP {}}}\n' {{$PBASIC 2.5}}\n"
    sources = {
        "tx": f"{head.format(sender)}PAUSE 30\n"
        f'SEROUT 4\\5, {word_of(sender, rate) | mode}, ["{TEXT}"]\nEND\n',
        "rx": f"{head.format(taker)}seen VAR Byte(8)\nturn VAR Nib\nPAUSE 60\n"
        f"{takes}\nEND\nlate:\nSTOP\n",
    }
    pull = "down" if mode & INVERTED else "up"
    wires = f'[wire.data]\nends = ["tx.P4", "rx.P4"]\npull = "{pull}"\n' + (
        f'[wire.go]\nends = ["tx.P5", "rx.P5"]\npull = "{pull}"\n'
    )
    chips = "".join(f'[chip.{name}]\nsource = "{name}"\n' for name in sources)
    bench = parse_bench(
        f'format = "cgagen-bench-1"\n{chips}{wires}',
        "flow.toml",
        Path("."),
        lambda path: tokenizer.compile(sources[path.name], path.name),
    )
    bench.run(until_ns=1_500_000_000)
    seen = bench.chip("rx").ram.array("seen")
    return bytes(seen).decode("latin-1")


@pytest.mark.parametrize("how", RECEIVERS)
@pytest.mark.parametrize("mode", [0, INVERTED, SEVEN, INVERTED | OPEN, OPEN])
@pytest.mark.parametrize("model", [row.name for row in CHIPS])
def test_nothing_is_lost(tokenizer: Tokenizer, model: str, mode: int, how: str) -> None:
    rates = [rate for rate in RATES if word_of(model, rate) <= 0x1FFF]
    seen = {rate: received(tokenizer, model, model, rate, mode, how) for rate in rates}
    assert seen == dict.fromkeys(rates, TEXT)


@pytest.mark.parametrize(
    ("sender", "taker"), list(itertools.permutations([row.name for row in CHIPS], 2))
)
def test_nothing_is_lost_between_different_models(
    tokenizer: Tokenizer, sender: str, taker: str
) -> None:
    assert chip(sender) != chip(taker)
    for rate, how in itertools.product((4800, 19200), ("one by one", "items")):
        assert received(tokenizer, sender, taker, rate, INVERTED, how) == TEXT


def test_without_the_flow_pin_most_of_it_is_lost(tokenizer: Tokenizer) -> None:
    """S2 p. 410: the receiver catches the first byte at most."""
    head = "' {$STAMP BS2}\n' {$PBASIC 2.5}\nseen VAR Byte(8)\nturn VAR Nib\n"
    sources = {
        "tx": head + f'PAUSE 90\nSEROUT 4, 84, ["{TEXT}"]\nEND\n',
        "rx": head + "FOR turn = 0 TO 7 : SERIN 4, 84, [seen(turn)] : PAUSE 3 : NEXT\nEND\n",
    }
    bench = parse_bench(
        'format = "cgagen-bench-1"\n[chip.tx]\nsource = "tx"\n[chip.rx]\nsource = "rx"\n'
        '[wire.data]\nends = ["tx.P4", "rx.P4"]\npull = "up"\n',
        "bench.toml",
        Path("."),
        lambda path: tokenizer.compile(sources[path.name], path.name),
    )
    bench.run(until_ns=1_500_000_000)
    assert bytes(bench.chip("rx").ram.array("seen")).startswith(b"A")
    assert TEXT.encode() != bytes(bench.chip("rx").ram.array("seen"))
