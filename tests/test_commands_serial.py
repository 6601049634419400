"""SEROUT and SERIN against each other."""

from hypothesis import given
from hypothesis import strategies as st

from cgagen.emulator.commands.serial_in import serin
from cgagen.emulator.commands.serial_out import serout, serout_flow
from cgagen.emulator.wires import Wire
from tests.command_bench import MS, Bench, Got, Sent, ToyPort, text
from tests.serial_frames import INVERTED, NO_LABEL, OPEN, RATES, SEVEN


def both(
    baud: int,
    data: bytes,
    model: str,
    *,
    pull: int | None = None,
    sender_pin: int = 4,
    fetch_ns: int = 0,
) -> list[int]:
    """Send from one chip to another; what arrives."""
    bench, sender, taker = Bench(), ToyPort(model, "sender"), ToyPort(model, "taker")
    wire = Wire("line", pull=pull)
    sender.pins.connect(sender_pin, wire)
    taker.pins.connect(5, wire)
    sent = text(data, fetch_ns)
    items = [Got() for _ in data]
    take = bench.start(taker, serin(taker, items, timeout=NO_LABEL, baud=baud, pin=5))
    bench.run(0)
    bench.start(sender, serout(sender, sent, baud=baud, pin=sender_pin))
    bench.run()
    assert take.done_ns is not None
    return [item.taken[0] for item in items]


@given(
    st.sampled_from(sorted(RATES)),
    st.data(),
    st.binary(min_size=1, max_size=6),
    st.sampled_from([0, SEVEN, INVERTED, SEVEN | INVERTED]),
    st.booleans(),
)
def test_what_serout_sends_serin_receives(
    model: str, data: st.DataObject, payload: bytes, mode: int, is_open: bool
) -> None:
    _, word = data.draw(st.sampled_from(RATES[model]))
    mark = 0 if mode & INVERTED else 1
    got = both(word | mode | (OPEN if is_open else 0), payload, model, pull=mark)
    assert bytes(got) == bytes(byte & 0x7F if mode & SEVEN else byte for byte in payload)


@given(st.integers(0, 0x1FFF), st.binary(min_size=1, max_size=3))
def test_any_bit_time_does(word: int, payload: bytes) -> None:
    assert bytes(both(word, payload, "BS2p", pull=1)) == payload


@given(st.integers(0, 0xFFFF), st.sampled_from([0x01B6, 0x05B6, 0x01C0, 0x0DC0, 0x0B0E, 0x03E0]))
def test_a_number_goes_over_the_line(value: int, form: int) -> None:
    bench, sender, taker = Bench(), ToyPort("BS2", "sender"), ToyPort("BS2p", "taker")
    wire = Wire("line", pull=1)
    sender.pins.connect(0, wire)
    taker.pins.connect(0, wire)
    item = Got(form, 0)
    bench.start(taker, serin(taker, [item], timeout=NO_LABEL, baud=240, pin=0))
    bench.run(0)
    bench.start(sender, serout(sender, [Sent(form, value), Sent(13)], baud=84, pin=0))
    bench.run()
    # HEX2 keeps two digits of it
    assert item.taken == [value & 0xFF if form == 0x03E0 else value]


def test_two_chips_with_flow_control_lose_nothing() -> None:
    """S2 p. 424: the receiver takes one byte a second, and the sender waits."""
    bench, sender, taker = Bench(), ToyPort("BS2", "sender"), ToyPort("BS2", "taker")
    data_line, flow_line = Wire("data", pull=0), Wire("flow", pull=0)
    for port in (sender, taker):
        port.pins.connect(1, data_line)
        port.pins.connect(0, flow_line)
    flow = {"baud": 84 | INVERTED, "pin": 1, "flow_pin": 0}
    bench.start(sender, serout_flow(sender, text(b"HELLO!"), **flow))
    items = [Got() for _ in range(6)]
    for second, item in enumerate(items):
        bench.at(
            second * 1000 * MS,
            lambda item=item: bench.start(taker, serin(taker, [item], timeout=1, **flow)),  # type: ignore[misc]
        )
    bench.run()
    assert bytes(item.taken[0] for item in items) == b"HELLO!"
