"""Readings that were spoiled on their way: every refusal can be read, and none decides wrongly.

SIN is tied to SOUT, so what a chip answers while its host still sends is lost to both. The wire
is the emulated one, bit by bit, with the host's echo on it.
"""

from collections.abc import Iterator

import pytest

from cgagen.bench_protocol import ANSWER, END, READING_MS, parse_answer, reading_text
from cgagen.emulator.bench import BenchState
from cgagen.stamp.image import Image
from cgagen.tokenizer import compile_source
from hil.simulated import SimulatedTarget
from hil.subject import Subject, read_subject
from hil.target import Stimulus
from hil.trial import MS, Trial
from tests.subjects import FIRMWARE

LIMIT_MS = 2 * READING_MS
EXTRA = "05F"
"""Digits that come in between."""


def spoiled(reading: str) -> Iterator[str]:
    """A byte lost, one too many, one changed: at every place, CR included."""
    for at, byte in enumerate(reading):
        yield reading[:at] + reading[at + 1 :]
        for digit in EXTRA:
            yield reading[:at] + digit + reading[at:]
        for other in (chr(ord(byte) ^ 1 << bit) for bit in range(7)):
            if other != ANSWER:  # which would look like the answer's own beginning
                yield reading[:at] + other + reading[at + 1 :]


def reading_of(subject: Subject) -> tuple[str, int, int]:
    """A reading without two equal digits side by side at a number's edge, and its answer."""
    lights = (300, 0xFE1) if subject.robot.light else ()
    sonars = (0x0733, 0x1F80, 0xFFFF, 0x0A51, 0x9002, 0x4C31)[: len(subject.robot.sonars)]
    seen = SimulatedTarget(subject).decide(Stimulus(sonars, (False, False), lights))
    return reading_text(3, (*sonars, *lights)), seen.state or 0, seen.command


class Bench:
    """A main controller in bench mode, as often as it is wanted."""

    def __init__(self, role: str, image: Image | None = None) -> None:
        self.subject = read_subject(FIRMWARE / role)
        self.trial = Trial(self.subject, "main", image or self.subject.images["main"])
        assert self.trial.ask("?Hab") == "?Hab!Hab\r"
        self._state: BenchState = self.trial.bench.snapshot()

    def ask(self, reading: str) -> tuple[str, float]:
        """Return what is heard behind the readings up to the end of a line, and when, in ms."""
        trial = self.trial
        trial.bench.restore(self._state)
        trial.forget()
        said = trial.ask("?Qsx", reading, limit_ms=LIMIT_MS)
        silent_ns = trial.heard_ns[-1] - trial.heard_ns[-len("!Esx\r") - 1] if said else 0
        head = f"?Qsx>{reading}"
        return (said.removeprefix(head) if said.startswith(head) else said), silent_ns / MS


@pytest.mark.parametrize("role", ["predator", "prey"])
def test_every_refusal_can_be_read(role: str) -> None:
    bench = Bench(role)
    good, state, command = reading_of(bench.subject)
    right = f"!Qsx{state:02X}{command:X}\r"
    assert bench.ask(good)[0] == right
    ends = {"refused": 0, "answered": 0, "late": 0}
    for reading in spoiled(good):
        said, silent_ms = bench.ask(reading)
        assert said in (right, "!Esx\r"), f"{reading!r} is answered {said!r}"
        ends["answered" if said == right else "refused"] += 1
        ends["late"] += silent_ms > READING_MS
        if END not in reading:
            assert said == "!Esx\r", f"{reading!r}: the end is missing"
    assert ends["refused"] > 10 * ends["late"] > 0
    assert ends["answered"] > 0, "a lost leading zero changes nothing"


def test_after_a_refusal_the_same_question_is_answered() -> None:
    bench = Bench("predator")
    good, state, command = reading_of(bench.subject)
    for bad in (good[1:], good.replace("0733", "00733"), good.replace("FFFF", "FFF"), good[:-1]):
        assert bench.ask(bad)[0] == "!Esx\r"
        said = bench.trial.ask("?Qsx", good)
        assert parse_answer(said.rstrip(END)) == ("sx", state, command)


def test_a_chip_that_does_not_wait_for_the_end_speaks_into_its_host() -> None:
    """The test above sees it: without WAIT the refusal and the host's CR spoil each other."""
    subject = read_subject(FIRMWARE / "predator")
    source = subject.sources["main"]
    lines = [line for line in source.splitlines() if "WAIT (CR)" not in line]
    assert len(lines) == len(source.splitlines()) - 1
    changed = "\n".join(lines).replace("HEX4 check,", "HEX4 check]")
    bench = Bench("predator", compile_source(changed, "main.bsp").image)
    good, *_ = reading_of(bench.subject)
    heard = {bench.ask(good.replace("0733", bad))[0] for bad in ("0732", "07333")}
    assert not heard & {"!Esx\r"}
