"""The programmer against a fake Stamp with every fault everywhere."""

import pytest

from cgagen.errors import FlashError, RigError
from cgagen.flash.download import ATTEMPTS, State, download
from cgagen.flash.line import Line
from cgagen.flash.programmer import FlashReport, ask, program
from cgagen.flash.requests import Progress, TroubleError
from cgagen.stamp.chips import chip
from tests.fake_stamp import FakeChip, FakePort, Fault, Kind, SimClock
from tests.flash_plans import attempt, flash, holds, image_of, of, planned


def crossings(name: str) -> int:
    port = FakePort(FakeChip(name), SimClock())
    flash(port, image_of(of(name)))
    return port.crossings


@pytest.mark.parametrize("kind", Kind)
@pytest.mark.parametrize("name", ["BS2", "BS2p24", "BS2p40"])
def test_a_fault_at_every_byte(name: str, kind: Kind) -> None:
    """Never a half-programmed chip reported as good, never a hang; the second try succeeds."""
    image = image_of(of(name))
    mended = 0
    for position in range(crossings(name)):
        stamp, clock = FakeChip(name), SimClock()
        port = FakePort(stamp, clock, (Fault(kind, position),))
        result = attempt(port, image)
        if isinstance(result, FlashReport):
            assert holds(stamp, image), position
            assert stamp.state == "runs", position
            mended += result.attempts > 1
        else:
            begun = bool(stamp.writes) or any(byte >= 0x80 for byte in port.sent)
            assert isinstance(result, FlashError) == begun, (position, result)
            silent = "then the line fell silent" in str(result) and holds(stamp, image)
            assert silent or kind in (Kind.UNPLUGGED, Kind.POWER_OFF), (position, result)
        stamp.powered = True
        again = attempt(FakePort(stamp, clock), image)
        assert isinstance(again, FlashReport), (position, again)
        assert holds(stamp, image)
        assert stamp.state == "runs"
    assert mended or kind in (Kind.UNPLUGGED, Kind.POWER_OFF)


@pytest.mark.parametrize("kind", [Kind.LOST, Kind.DOUBLED, Kind.FLIPPED, Kind.LATE, Kind.VERY_LATE])
@pytest.mark.parametrize("name", ["BS2", "BS2p24"])
def test_one_attempt_alone_notices_every_fault_of_the_packets(name: str, kind: Kind) -> None:
    image = image_of(of(name))
    first = 8 + 4 if name == "BS2" else 3 + 2
    for position in range(first, first + 3 * 37):
        port = FakePort(FakeChip(name), SimClock(), (Fault(kind, position),), timeout=0.005)
        noticed = True
        try:
            Line(port, port.clock).converse(download(planned(image), State(), attempts=1))
            noticed = False
        except TroubleError:
            pass
        assert noticed or (kind is Kind.LATE and holds(port.chip, image)), position


@pytest.mark.parametrize("every", [5, 11, 23, 40])
@pytest.mark.parametrize("kind", [Kind.LOST, Kind.DOUBLED, Kind.FLIPPED])
def test_a_line_that_is_never_good_ends_in_an_error(kind: Kind, every: int) -> None:
    stamp, clock = FakeChip("BS2p24"), SimClock()
    result = attempt(FakePort(stamp, clock, (Fault(kind, 0, every),)), image_of("BS2p"))
    assert isinstance(result, RigError | FlashError)


TRANSIENT = [Kind.LOST, Kind.DOUBLED, Kind.FLIPPED, Kind.LATE, Kind.RESET]


@pytest.mark.parametrize("kind", TRANSIENT)
@pytest.mark.parametrize("name", ["BS2", "BS2e", "BS2p24"])
def test_a_fault_does_not_make_another_module(name: str, kind: Kind) -> None:
    """A doubled 'P' is what a BS2p40 would answer."""
    likely = (chip(of(name)),)
    for position in range(9 if name == "BS2" else 4):
        port = FakePort(FakeChip(name), SimClock(), (Fault(kind, position),), timeout=0.005)
        module = ask(Line(port, port.clock), "x", likely)
        assert module.model == likely[0]
        assert module.pins == 24


def test_a_slow_eeprom_and_one_that_is_too_slow() -> None:
    for write_s, good in ((0.9, True), (1.3, False)):
        port = FakePort(FakeChip("BS2", write_s=write_s), SimClock(), timeout=0.005)
        result = attempt(port, image_of("BS2"))
        assert isinstance(result, FlashReport) == good
        assert good or "no answer" in str(result)


def test_a_chip_that_finds_every_packet_broken() -> None:
    port = FakePort(FakeChip("BS2", deaf=True), SimClock())
    with pytest.raises(FlashError, match=r"found block 0 .* broken again and again"):
        flash(port, image_of("BS2"))


def test_a_program_that_the_sign_off_does_not_start_is_started() -> None:
    stamp = FakeChip("BS2p24", starts_by_itself=False)
    assert not flash(FakePort(stamp, SimClock()), image_of("BS2p")).talks
    assert (stamp.state, stamp.starts) == ("runs", 1)


def test_an_adapter_that_echoes_too_is_no_bs2p40() -> None:
    stamp = FakeChip("BS2p24", atn_works=False)
    with pytest.raises(RigError, match="every byte comes back twice"):
        flash(FakePort(stamp, SimClock(), echoes=2, timeout=0.005), image_of("BS2p"))


def test_attempts_are_bounded() -> None:
    stamp = FakeChip("BS2")
    port = FakePort(stamp, SimClock(), (Fault(Kind.FLIPPED, 30, 45),))
    state = State()
    with pytest.raises(TroubleError):
        Line(port, port.clock).converse(download(planned(image_of("BS2")), state))
    assert state.attempt == ATTEMPTS


def test_a_worn_eeprom_is_tried_once_more_and_then_named() -> None:
    port = FakePort(FakeChip("BS2", worn_block=126), SimClock())
    with pytest.raises(FlashError, match=r"EEPROM does not take block 126 .*half a program"):
        flash(port, image_of("BS2"))
    assert port.chip.writes == [0, 0]


def test_a_port_that_goes_when_all_is_acknowledged_says_so() -> None:
    last = crossings("BS2") - 1
    port = FakePort(FakeChip("BS2"), SimClock(), (Fault(Kind.UNPLUGGED, last),))
    with pytest.raises(FlashError, match="every packet had been acknowledged"):
        flash(port, image_of("BS2"))
    assert holds(port.chip, image_of("BS2"))


def test_ctrl_c_in_the_middle_says_what_the_chip_holds() -> None:
    def stop(progress: Progress) -> None:
        raise KeyboardInterrupt

    port = FakePort(FakeChip("BS2"), SimClock())
    with pytest.raises(FlashError, match="stopped in the middle; the chip holds half"):
        program(Line(port, port.clock), "x", planned(image_of("BS2")), stop)


def test_ctrl_c_before_anything_is_sent_leaves_the_old_program_running() -> None:
    class Pressed(FakePort):
        def write(self, data: bytes) -> int:
            raise KeyboardInterrupt

    port = Pressed(FakeChip("BS2"), SimClock())
    with pytest.raises(KeyboardInterrupt):
        program(Line(port, port.clock), "x", planned(image_of("BS2")))
    assert (port.chip.state, port.chip.starts) == ("runs", 1)
