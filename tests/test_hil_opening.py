"""Targets opened: loaded where they hold another program, tried again where the bench is sick."""

from pathlib import Path

import pytest

import cgagen.flash
from cgagen.errors import IdentityError, RigError, TargetTimeout
from cgagen.serve import serve
from cgagen.stamp.chips import EEPROM_BYTES
from cgagen.stamp.image import Image
from hil import opening
from hil.emulated import robot_bench
from hil.equivalence import Verdict, compare
from hil.opening import open_target
from hil.pipe import BytePipe
from hil.stimuli import every_state
from hil.subject import Subject, read_subject
from hil.targets import make_target
from hil.wired import OtherChipError

URL, RESET_URL = "serial:/dev/somewhere", "serial-reset:/dev/somewhere"


class Bench:
    """A port, what was done to it, and the errors of the next openings."""

    def __init__(self, *errors: Exception) -> None:
        self.errors = list(errors)
        self.done: list[str] = []

    def make(self, url: str, _subject: Subject) -> "Bench":
        self.done.append(f"make {url}")
        return self

    def open(self) -> None:
        self.done.append("open")
        if self.errors:
            raise self.errors.pop(0)

    def close(self) -> None:
        self.done.append("close")

    def flash(self, port: str, image: Image) -> None:
        self.done.append(f"flash {port} {image.digest[:8]}")

    @property
    def flashes(self) -> int:
        return sum(one.startswith("flash") for one in self.done)


@pytest.fixture(scope="module")
def subject() -> Subject:
    return read_subject(Path(__file__).parent.parent / "firmware" / "prey")


def opened(
    monkeypatch: pytest.MonkeyPatch, subject: Subject, bench: Bench, url: str, *words: object
) -> object:
    monkeypatch.setattr(opening, "make_target", bench.make)
    monkeypatch.setattr(cgagen.flash, "flash_image", bench.flash)
    return open_target(url, subject, *words)  # type: ignore[arg-type]


def test_another_program_is_loaded_over_once(
    monkeypatch: pytest.MonkeyPatch, subject: Subject
) -> None:
    bench = Bench(IdentityError("another image"))
    assert opened(monkeypatch, subject, bench, URL, "auto") is bench
    assert bench.flashes == 1
    assert f"flash /dev/somewhere {subject.images['main'].digest[:8]}" in bench.done
    assert bench.done[-1] == "open"
    reset = Bench(IdentityError("another image"))
    opened(monkeypatch, subject, reset, RESET_URL, "auto")
    assert f"flash /dev/somewhere {subject.images['main'].digest[:8]}" in reset.done
    stubborn = Bench(IdentityError("first"), IdentityError("again"))
    with pytest.raises(IdentityError, match="again"):
        opened(monkeypatch, subject, stubborn, URL, "auto", 5)
    assert stubborn.flashes == 1
    assert stubborn.done[-1] == "close"


def test_a_chip_is_left_alone_or_loaded_in_any_case(
    monkeypatch: pytest.MonkeyPatch, subject: Subject
) -> None:
    bench = Bench(IdentityError("another image"))
    with pytest.raises(IdentityError):
        opened(monkeypatch, subject, bench, URL, "never", 3)
    assert bench.flashes == 0
    right = Bench()
    opened(monkeypatch, subject, right, URL, "always")
    assert right.done[0].startswith("flash")
    same = Bench()
    opened(monkeypatch, subject, same, URL, "auto")
    assert same.flashes == 0
    for url in ("emulator", "can:virtual:bench"):
        other = Bench(IdentityError("another image"))
        with pytest.raises(IdentityError):
            opened(monkeypatch, subject, other, url, "auto")
        assert other.flashes == 0


def test_a_sick_bench_is_tried_again_and_a_hanging_program_is_not(
    monkeypatch: pytest.MonkeyPatch, subject: Subject
) -> None:
    bench = Bench(RigError("loose"), RigError("loose"))
    assert opened(monkeypatch, subject, bench, URL, "never", 2) is bench
    assert bench.done.count("open") == 3
    with pytest.raises(RigError, match="loose"):
        opened(monkeypatch, subject, Bench(RigError("loose")), URL)
    hangs = Bench(TargetTimeout("hangs"))
    with pytest.raises(TargetTimeout):
        opened(monkeypatch, subject, hangs, URL, "never", 4)
    assert hangs.done.count("open") == 1


def test_a_silent_chip_is_loaded_if_there_is_one_that_may_be_reset(
    monkeypatch: pytest.MonkeyPatch, subject: Subject
) -> None:
    """A robot at work is silent, too, and opening its port must not reset it."""
    bench = Bench(RigError("silent"))
    assert opened(monkeypatch, subject, bench, RESET_URL, "auto") is bench
    assert bench.flashes == 1
    at_work = Bench(RigError("silent"))
    with pytest.raises(RigError, match="silent"):
        opened(monkeypatch, subject, at_work, URL, "auto")
    assert at_work.flashes == 0
    monkeypatch.setattr(Bench, "flash", lambda *_: Bench(RigError("no Stamp")).open())
    with pytest.raises(RigError, match="silent"):
        opened(monkeypatch, subject, Bench(RigError("silent")), RESET_URL, "auto")


def test_the_other_controller_is_never_loaded_over(
    monkeypatch: pytest.MonkeyPatch, subject: Subject
) -> None:
    """On a robot with two chips of one model nothing else would stop it."""
    bench = Bench(OtherChipError("the other one"))
    with pytest.raises(OtherChipError):
        opened(monkeypatch, subject, bench, RESET_URL, "auto")
    assert bench.flashes == 0
    with BytePipe(robot_bench(subject.robot, subject.images), "locomotion") as pipe:
        target = make_target(f"serial:{pipe.url}", subject)
        with pytest.raises(OtherChipError, match="give the other port"):
            target.open()


def test_an_erased_chip_on_a_port_is_loaded_and_decides(subject: Subject) -> None:
    """The whole way: our programmer, the chip's loader, the bench hook; DTR over RFC 2217."""
    image = subject.images["main"]
    erased = Image(image.model, bytes(EEPROM_BYTES), slot=image.slot)
    bench = robot_bench(subject.robot, {**subject.images, "main": erased})
    with serve(bench, "rfc2217:0") as server:
        target = open_target(f"serial-reset:{server.url}", subject, "auto")
        try:
            trial = compare(subject, target, list(every_state(subject.robot).values())[:2])
        finally:
            target.close()
    assert (trial.verdict, trial.decisions) == (Verdict.PASS, 2)
    assert bench.chip("main").eeprom() == image.eeprom
