"""The programmer against a fake Stamp written from the documents, with every fault everywhere."""

import random
from functools import cache

import pytest

from cgagen.errors import FlashError, ImageError, RigError
from cgagen.flash.download import ATTEMPTS, State, download
from cgagen.flash.identify import identify
from cgagen.flash.line import Line
from cgagen.flash.modules import CALLINGS
from cgagen.flash.plan import plan_of
from cgagen.flash.programmer import FlashReport, ask, program
from cgagen.flash.requests import Progress, Symptom, TroubleError
from cgagen.stamp.chips import CHIPS, chip
from cgagen.stamp.image import SENT, Image, Use
from tests.fake_stamp import MODELS, FakeChip, FakePort, Fault, Kind, SimClock

LONGEST_S = 30.0
"""No try may take longer, in the line's own time."""


@cache
def image_of(model: str, blocks: tuple[int, ...] = (0, 126, 127), slot: int = 0) -> Image:
    """An image whose marked blocks hold chance; a packet with checksum 00 is among them."""
    chance = random.Random(model)
    eeprom, flags = bytearray(2048), bytearray(2048)
    for block in blocks:
        span = slice(block * 16, block * 16 + 16)
        eeprom[span] = chance.randbytes(16)
        flags[span] = bytes((Use.PROGRAM | SENT,)) * 16
    last = blocks[-1] * 16
    eeprom[last + 13 : last + 15] = b"\0\0"
    eeprom[last + 15] = 0
    eeprom[last] = -(0x80 + blocks[-1] + sum(eeprom[last + 1 : last + 16])) & 0xFF
    return Image(chip(model), bytes(eeprom), bytes(flags), slot)


planned = cache(plan_of)


def of(name: str) -> str:
    """The model of a module."""
    return name.removesuffix("24").removesuffix("40")


def flash(port: FakePort, image: Image) -> FlashReport:
    return program(Line(port, port.clock), "/dev/fake", planned(image))


def holds(stamp: FakeChip, image: Image) -> bool:
    plan = planned(image)
    eeprom = stamp.slots[image.slot]
    return all(
        eeprom[n * 16 : n * 16 + 16] == image.eeprom[n * 16 : n * 16 + 16] for n in plan.blocks
    )


@pytest.mark.parametrize("name", MODELS)
def test_every_model_is_identified(name: str) -> None:
    port = FakePort(FakeChip(name), SimClock())
    module = ask(Line(port, port.clock), "/dev/fake")
    assert module.name in (name, name.removesuffix("24"))
    assert module.pins == (40 if name.endswith("40") else 24)
    assert port.chip.state == "runs"
    assert port.chip.starts == 1


@pytest.mark.parametrize("name", MODELS)
def test_every_model_takes_an_image(name: str) -> None:
    port = FakePort(FakeChip(name), SimClock())
    image = image_of(of(name))
    report = flash(port, image)
    assert holds(port.chip, image)
    assert port.chip.writes == [0, 126, 127]
    assert (report.attempts, report.blocks, report.talks) == (1, (0, 126, 127), False)
    assert port.chip.state == "runs"


def test_the_bytes_on_the_line_are_those_of_the_documents() -> None:
    port = FakePort(FakeChip("BS2"), SimClock())
    image = image_of("BS2")
    flash(port, image)
    assert bytes(port.sent) == b"BS2\0" + b"".join(planned(image).packets) + b"\0"
    port = FakePort(FakeChip("BS2p24"), SimClock())
    image = image_of("BS2p", slot=5)
    flash(port, image)
    assert bytes(port.sent) == b"P\x05" + b"".join(planned(image).packets) + b"\0"


@pytest.mark.parametrize("slot", range(8))
def test_all_slots(slot: int) -> None:
    port = FakePort(FakeChip("BS2pe24"), SimClock())
    image = image_of("BS2pe", slot=slot)
    assert flash(port, image).slot == slot
    assert holds(port.chip, image)
    others = [n for n in port.chip.slots if n != slot]
    assert all(set(port.chip.slots[n]) == {0xFF} for n in others)


def test_an_image_without_flags_is_sent_whole() -> None:
    port = FakePort(FakeChip("BS2"), SimClock())
    eeprom = random.Random(3).randbytes(2048)
    report = flash(port, Image(chip("BS2"), eeprom))
    assert bytes(port.chip.slots[0]) == eeprom
    assert report.blocks == tuple(range(128))
    assert port.chip.writes == list(range(128))


def test_progress_comes_with_every_packet() -> None:
    port = FakePort(FakeChip("BS2"), SimClock())
    told: list[Progress] = []
    program(Line(port, port.clock), "x", planned(image_of("BS2")), told.append)
    assert told == [Progress(1, 3, 1), Progress(2, 3, 1), Progress(3, 3, 1)]


def test_a_program_that_talks_is_not_started_twice() -> None:
    stamp = FakeChip("BS2p24", program=lambda chip: [(0.002, byte) for byte in b"#1 M"])
    port = FakePort(stamp, SimClock())
    assert flash(port, image_of("BS2p")).talks
    assert stamp.starts == 1


@pytest.mark.parametrize(
    ("there", "wanted"), [("BS2", "BS2p"), ("BS2p40", "BS2"), ("BS2e", "BS2sx")]
)
def test_a_wrong_model_is_refused_before_anything_is_sent(there: str, wanted: str) -> None:
    port = FakePort(FakeChip(there), SimClock())
    with pytest.raises(RigError, match=rf"this is a {there}, the image is for a {wanted}; noth"):
        flash(port, image_of(wanted))
    assert port.chip.writes == []
    assert port.chip.state == "runs"


# -- Symptoms ---------------------------------------------------------------------------------


def symptom_of(port: FakePort) -> Symptom:
    with pytest.raises(TroubleError) as met:
        Line(port, port.clock).converse(identify())
    assert port.clock.now_s() - 100 < LONGEST_S
    return met.value.symptom


def test_no_echo() -> None:
    assert symptom_of(FakePort(FakeChip("BS2", powered=False), SimClock())) is Symptom.NO_ECHO


def test_echo_and_no_answer() -> None:
    stamp = FakeChip("BS2", atn_works=False)
    assert symptom_of(FakePort(stamp, SimClock())) is Symptom.NO_ANSWER


def test_an_adapter_that_echoes_too() -> None:
    """A BS2p40 answers 'P' with 'P': a doubled echo must not be taken for one."""
    stamp = FakeChip("BS2", atn_works=False)
    assert symptom_of(FakePort(stamp, SimClock(), echoes=2)) is Symptom.DOUBLE_ECHO


def test_a_stamp_that_talks_through_its_reset() -> None:
    class Babble(FakePort):
        @property
        def in_waiting(self) -> int:
            return 5

        def read(self, size: int = 1) -> bytes:
            self.clock.sleep(0.001 * size)
            return b"u" * size

    assert symptom_of(Babble(FakeChip("BS2"), SimClock())) is Symptom.TALKING


@pytest.mark.parametrize("every_s", [0.004, 0.011, 0.03, 0.1])
@pytest.mark.parametrize("name", ["BS2", "BS2p24"])
def test_somebody_else_talks_on_the_line(name: str, every_s: float) -> None:
    """Slow chatter may let a download through; a false success it may not make."""
    stamp, clock = FakeChip(name), SimClock()
    result = attempt(
        FakePort(stamp, clock, noise_every_s=every_s, timeout=0.005), image_of(of(name))
    )
    assert not isinstance(result, FlashReport) or holds(stamp, image_of(of(name)))
    assert isinstance(result, FlashReport | RigError | FlashError)
    if every_s < 0.02:
        assert "goes on talking through a reset" in str(result)
    assert isinstance(attempt(FakePort(stamp, clock), image_of(of(name))), FlashReport)


@pytest.mark.parametrize("every", [1, 2, 3])
def test_garbage_on_the_line(every: int) -> None:
    port = FakePort(FakeChip("BS2"), SimClock(), (Fault(Kind.FLIPPED, 0, every),))
    assert symptom_of(port) in (Symptom.WRONG_ECHO, Symptom.WRONG_ANSWER)


def test_a_program_that_talked_before_the_reset_is_no_trouble() -> None:
    stamp = FakeChip("BS2p24", program=lambda chip: [(n * 0.005, 0x55) for n in range(2000)])
    port = FakePort(stamp, SimClock())
    port._schedule(port.clock.now_s(), stamp.start())
    port.clock.sleep(1)
    image = image_of("BS2p")
    assert flash(port, image).talks
    assert holds(stamp, image)


@pytest.mark.parametrize("symptom", [one for one in Symptom if one is not Symptom.WRONG_MODEL])
def test_every_symptom_has_a_sentence_with_a_hint(symptom: Symptom) -> None:
    from cgagen.flash.diagnoses import sentence_of

    for begun in (False, True):
        text = sentence_of(TroubleError(symptom, "12h"), "/dev/x", "BS2", begun)
        assert text.startswith("/dev/x: ")
        assert "12h" in text
        assert ("half a program" in text) == begun


# -- Faults at every byte ---------------------------------------------------------------------


def crossings(name: str) -> int:
    port = FakePort(FakeChip(name), SimClock())
    flash(port, image_of(of(name)))
    return port.crossings


def attempt(port: FakePort, image: Image) -> FlashReport | RigError | FlashError:
    started_s = port.clock.now_s()
    try:
        return flash(port, image)
    except (RigError, FlashError) as error:
        return error
    finally:
        assert port.clock.now_s() - started_s < LONGEST_S


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


# -- What would be sent -----------------------------------------------------------------------


def test_flags_that_cannot_be_are_refused() -> None:
    good = image_of("BS2")
    assert good.flags is not None
    for at, flag, words in (
        (5, Use.PROGRAM, "half of block 0"),
        (500, Use.DATA, "block 31 holds"),
    ):
        flags = bytearray(good.flags)
        flags[at] = flag
        with pytest.raises(ImageError, match=words):
            plan_of(Image(good.model, good.eeprom, bytes(flags)))
    with pytest.raises(ImageError, match="start of its program"):
        plan_of(Image(good.model, good.eeprom, bytes(2048)))


def test_the_callings_are_those_of_the_chips() -> None:
    assert [calling.model for calling in CALLINGS] == list(CHIPS)
    assert [calling.takes_slot for calling in CALLINGS] == [False, True, True, True, True]


def test_a_dry_run_says_all_bytes() -> None:
    text = plan_of(image_of("BS2p", slot=3)).to_text()
    assert "slot byte 03h, 3 packets" in text
    assert "blocks 0, 126-127 of 128" in text
    assert text.count("\n") == 4
