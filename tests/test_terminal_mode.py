"""A terminal at any rate that SERIN and SEROUT have on pin 16, and one at another rate."""

import json
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cgagen.emulator.conversation import Conversation
from cgagen.emulator.line_watch import Edge, mode_of
from cgagen.emulator.programs import bench_of_sources
from cgagen.emulator.session import run_session
from cgagen.stamp.serial_mode import SerialMode, parse_mode
from cgagen.tokenizer import Tokenizer
from cgagen.verbs.keyboard import from_text
from tests.emulate_cases import BASIC, Emulate, Program
from tests.serial_frames import frame_7e1, frame_8n1

SEVEN_EVEN = 0x2000
SLOW = [("BS2", baud) for baud in (300, 1200, 2400, 4800, 9600, 19_200, 38_400)]
MODES = [
    *SLOW,
    *(("BS2e", baud) for baud in (300, 9600)),
    *(("BS2pe", baud) for baud in (2400, 19_200)),
    *(("BS2sx", baud) for baud in (608, 2400, 9600, 57_600)),
    *(("BS2p", baud) for baud in (608, 4800, 9600, 38_400, 57_600)),
]
"""Models and rates. Ref: S2 p. 394, 416."""


def word_of(model: str, baud: int) -> int:
    """Return the baud word of a rate. Ref: S2 p. 395, 419 (a BS2sx and a BS2p count 0.4 us)."""
    return (2_500_000 if model in ("BS2sx", "BS2p") else 1_000_000) // baud - 20


def talked(
    tokenizer: Tokenizer, body: str, typed: str, mode: SerialMode, model: str
) -> Conversation:
    """Let a program talk with a terminal; what the chip has said is in `SAID`."""
    compiled = tokenizer.compile(f"' {{$STAMP {model}}}\n' {{$PBASIC 2.5}}\n{body}\nEND\n")
    bench = bench_of_sources({0: compiled})
    chip = bench.chips["main"]
    terminal = Conversation(bench, chip, SAID.append, from_text(typed), mode=mode)
    SAID.clear()
    run_session(bench, chip, terminal, 20_000_000_000)
    return terminal


SAID = bytearray()


@pytest.mark.parametrize(("model", "baud"), MODES)
@pytest.mark.parametrize("flags", [0, 0x4000, 0x8000, 0xC000, SEVEN_EVEN, SEVEN_EVEN | 0x4000])
def test_any_mode_goes_both_ways(tokenizer: Tokenizer, model: str, baud: int, flags: int) -> None:
    """On the programming port it does not matter what a word says of polarity (S2 p. 419)."""
    word = word_of(model, baud) | flags
    mode = SerialMode(baud, bool(flags & SEVEN_EVEN))
    body = f'SERIN 16, {word}, [B0, B1]\nSEROUT 16, {word}, ["<", B1, B0, ">"]'
    terminal = talked(tokenizer, body, "ab", mode, model)
    assert SAID == b"<ba>"
    assert (terminal.watch.fitting(), terminal.listened, terminal.typed) == (None, None, 2)


@pytest.mark.parametrize("other", [SerialMode(9600), SerialMode(2400), SerialMode(19_200, True)])
@pytest.mark.parametrize(("model", "baud"), MODES)
@pytest.mark.parametrize("seven_even", [False, True])
def test_the_mode_that_would_fit_is_measured(
    tokenizer: Tokenizer, model: str, baud: int, seven_even: bool, other: SerialMode
) -> None:
    word = word_of(model, baud) | SEVEN_EVEN * seven_even
    sent = SerialMode(baud, seven_even)
    body = f'SEROUT 16, {word}, ["count = 17", 13]'
    fits = talked(tokenizer, body, "", other, model).watch.fitting()
    if sent == other:
        assert fits is None
    else:
        assert fits is not None
        assert (fits.baud, fits.seven_even) == (pytest.approx(baud, rel=0.02), seven_even)


@pytest.mark.parametrize("text", ["U", "a", "<a>", "33", "\\"])
def test_few_bytes_are_enough(tokenizer: Tokenizer, text: str) -> None:
    body = f'DEBUG "Ready", CR\nPAUSE 20\nSEROUT 16, 396, ["{text}"]'
    fits = talked(tokenizer, body, "", SerialMode(), "BS2").watch.fitting()
    assert fits == SerialMode(2400)


def test_a_rate_that_nobody_uses_is_told_too(tokenizer: Tokenizer) -> None:
    fits = talked(tokenizer, 'SEROUT 16, 1000, ["Hello"]', "", SerialMode(), "BS2").watch.fitting()
    assert fits is not None
    assert fits.baud == pytest.approx(980, abs=2)


@pytest.mark.parametrize(
    "body",
    [
        'DEBUG "Hello", CR\nDEBUG REP "U"\\200',
        "FOR B0 = 0 TO 254\nDEBUG B0\nNEXT",
        "DEBUG 255, 255, 0, 0, 15, 240",
        'SEROUT 16, 84, 7, ["paced", CR]\nPAUSE 3\nDEBUG 1',
        'SEROUT 16, 86, ["a bit slower"]\nSEROUT 16, 82, ["a bit faster"]',
    ],
)
def test_what_is_heard_raises_no_alarm(tokenizer: Tokenizer, body: str) -> None:
    assert talked(tokenizer, body, "", SerialMode(), "BS2").watch.fitting() is None


@given(
    st.text(st.characters(min_codepoint=32, max_codepoint=126), min_size=2, max_size=12),
    st.sampled_from([300, 1200, 2400, 4800, 9600, 14_400, 19_200, 38_400, 57_600]),
    st.integers(0, 5000),
    st.booleans(),
)
@settings(max_examples=300, deadline=None)
def test_the_rate_of_any_text_is_found(text: str, baud: int, pause_us: int, seven: bool) -> None:
    """From edges alone: the last bit of a character is 0, so no slower rate has all of them."""
    bit_ns = 1_000_000_000 // baud
    levels: list[tuple[int, bool]] = [(-1, False)]
    now_ns = 0
    for byte in text.encode("ascii"):
        frame = frame_7e1(byte) if seven else frame_8n1(byte)
        levels += [(now_ns + place * bit_ns, not frame >> place & 1) for place in range(10)]
        now_ns += 10 * bit_ns + pause_us * 1000
    edges: list[Edge] = [two for one, two in pairwise(levels) if one[1] != two[1]]
    mode = mode_of(edges, now_ns + 20 * bit_ns)
    if seven and any(byte.bit_count() & 1 for byte in text.encode("ascii")):
        assert mode is not None
        assert mode.seven_even or mode.baud < baud
    else:
        assert mode == SerialMode(baud)


# -- as a user sees it --------------------------------------------------------------------------

ECHO = 'SERIN 16, 396, 1000, late, [B0]\nSEROUT 16, 396, ["<", B0, ">"]\nEND\nlate:\nDEBUG "late"\n'


def test_one_note_says_which_rate_would_fit(emulate: Emulate, program: Program) -> None:
    path = program(BASIC + ECHO)
    assert emulate(path, "--input", "a", "--baud", "2400") == (0, "<a>", "")
    code, out, err = emulate(path, "--input", "a")
    assert (code, err) == (
        0,
        "note: main sends at 2400, and the terminal listens at 9600: --baud 2400 shows what it "
        "says\n",
    )
    assert "<a>" not in out
    code, out, _ = emulate(path, "--input", "a", "--json")
    told = json.loads(out)
    assert (told["baud"], told["baud_fits"]) == ("9600", "2400")


def test_input_at_another_rate_is_told_where_nothing_comes_back(
    emulate: Emulate, program: Program
) -> None:
    path = program(BASIC + "x VAR Byte\nSERIN 16, 813, [DEC x]\nSEROUT 16, 813, [DEC x]\n")
    assert emulate(path, "--input", "7\n", "--baud", "1200")[:2] == (0, "7")
    code, out, err = emulate(path, "--input", "7\n", "--expect-end")
    assert (code, out) == (9, "")
    assert "the program listens at 1200, and what was typed came at 9600: --baud 1200" in err
    assert "it.bs2:4: the program waits for input at 1200" in err
    assert "does not come" not in err
    assert "give --baud 1200" in err


@pytest.mark.parametrize("mode", ["0", "99", "250001", "fast", "2400-8E1", "2400-7", "-1", "1e4"])
def test_what_is_no_mode_is_refused(emulate: Emulate, program: Program, mode: str) -> None:
    code, out, err = emulate(program(BASIC + "END\n"), "--baud", mode)
    assert (code, out) == (2, "")
    assert "2400 or 2400-7E1" in err
    assert parse_mode(mode) is None


def test_modes_as_they_are_written() -> None:
    for text in ("2400-7E1", "2400,7e1", " 2400/7E1 ", "2400 7E1"):
        assert parse_mode(text) == (2400, True)
    assert parse_mode("2400-8n1") == parse_mode("2400") == (2400, False)
