"""The programmer against a fake Stamp written from the documents: what it sends, and symptoms."""

import random

import pytest

from cgagen.errors import FlashError, ImageError, RigError
from cgagen.flash.identify import identify
from cgagen.flash.line import Line
from cgagen.flash.modules import CALLINGS
from cgagen.flash.plan import plan_of
from cgagen.flash.programmer import FlashReport, ask, program
from cgagen.flash.requests import Progress, Symptom, TroubleError
from cgagen.stamp.chips import CHIPS, chip
from cgagen.stamp.image import Image, Use
from tests.fake_stamp import MODELS, FakeChip, FakePort, Fault, Kind, SimClock
from tests.flash_plans import LONGEST_S, attempt, flash, holds, image_of, of, planned


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
    port.schedule(port.clock.now_s(), stamp.start())
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
