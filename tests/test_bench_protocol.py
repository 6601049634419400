"""The words of the protocol, and that its page and the programs speak the same ones."""

import re
from pathlib import Path

import pytest

from cgagen import bench_protocol as protocol
from cgagen.firmware import generate
from tests.firmware_cases import GENOME, robot_of

PAGE = (Path(__file__).parent.parent / "PROTOCOL.md").read_text("utf-8")
PROGRAMS = {
    (case, program.chip): program.source
    for case, genome in (("predator", GENOME), ("prey", None))
    for program in generate(robot_of(case), genome).programs
}


def test_the_page_explains_every_letter_and_fault() -> None:
    for letter in protocol.Letter:
        assert re.search(rf"`[?!]{letter}|letter `{letter}`", PAGE), letter
    for fault in protocol.Fault:
        assert f"| `*{fault}` |" in PAGE
    for sign in (protocol.BANNER, protocol.ANSWER, protocol.DUMP_LINE, protocol.TELEMETRY):
        assert f"| `{sign}" in PAGE


def test_the_page_has_the_times() -> None:
    for words in (
        f"at least {protocol.LISTEN_MS} ms",
        f"main {protocol.MAIN_SLICE_MS} ms, locomotion {protocol.LOCOMOTION_SLICE_MS} ms",
        f"for {protocol.READING_MS} ms for each byte",
        f"They begin {protocol.PROMPT_GAP_MS} ms after the prompt",
        f"leaving {protocol.BYTE_GAP_MS} ms between two bytes",
        f"blocks `a` to `b` of {protocol.DUMP_BLOCK_BYTES} bytes",
    ):
        assert words in PAGE


def test_the_pages_examples_are_true() -> None:
    assert protocol.reading_text(3, (0x733, 0, 0xFFFF, 0xAA, 0)).strip() in PAGE
    assert protocol.dump_request(0, 2047) in PAGE
    line = re.search(r"^    (#1 .*)$", PAGE, re.MULTILINE)
    assert line
    assert protocol.parse_banner(line[1]) == (1, "main", "servobot-predator", "05d90b7a",
                                              "8212b873")  # fmt: skip


@pytest.mark.parametrize("chip", ["main", "locomotion"])
@pytest.mark.parametrize("case", ["predator", "prey"])
def test_the_programs_know_their_letters(case: str, chip: str) -> None:
    source = PROGRAMS[case, chip]
    letters = set(re.findall(r'request\(1\) = "(.)" THEN Bench\w*', source))
    both = {protocol.Letter.HELLO, protocol.Letter.DUMP, protocol.Letter.LEAVE}
    own = (
        {protocol.Letter.QUESTION}
        if chip == "main"
        else {protocol.Letter.MOVE, protocol.Letter.CENTRE}
    )
    assert letters == both | own
    faults = set(re.findall(r'"\*(\w+)"', source))
    of_main = {"BUSY", "CUT", "REFUSED"} | ({"BRIGHT"} if case == "predator" else set())
    assert faults == (of_main if chip == "main" else {"LOW", "IDLE", "LINES"})


def test_what_is_no_word_of_the_protocol_is_told_from_what_is() -> None:
    for line in ("", "#1 M robot 12345678", "#x M robot 12345678 12345678", "1 M r a b"):
        assert protocol.parse_banner(line) is None
    for line in ("", "!Q5A0F", "!Q5A0F22", "!H5A0F2", "!Q5AxF2"):
        assert protocol.parse_answer(line) is None
    for line in ("", "=7F0 00", "=7F00 " + "00" * 16, "7F0 " + "00" * 16, "=7F0 " + "0x" * 16):
        assert protocol.parse_dump(line) is None


@pytest.mark.parametrize(
    "call",
    [
        lambda: protocol.request_text(protocol.Letter.MOVE, "10", "a"),
        lambda: protocol.request_text(protocol.Letter.MOVE, " ", "a"),
        lambda: protocol.reading_text(4, (0,)),
        lambda: protocol.reading_text(0, (65536,)),
        lambda: protocol.dump_request(5, 4),
        lambda: protocol.dump_request(0, 2048),
    ],
)
def test_what_does_not_fit_is_refused(call: object) -> None:
    assert callable(call)
    with pytest.raises(ValueError, match=r"is not|are not"):
        call()
