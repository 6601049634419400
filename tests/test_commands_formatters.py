"""Numbers as text: the manual's own examples and tables, and both ways against each other."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cgagen.emulator.commands.formatters import NumberReader, format_of, text_of
from cgagen.errors import ExecutionError


def word(
    radix: int,
    digits: int = 0,
    *,
    signed: bool = False,
    indicated: bool = False,
    any_radix: bool = False,
) -> int:
    """Put a formatter word together as the tokenizer does (S3)."""
    most = {10: 5, 16: 4, 2: 16}[radix]
    return (
        (16 - radix) & 15
        | ((16 - (digits or most)) & 15) << 4
        | 0x100
        | (0x200 if digits else 0)
        | signed << 10
        | indicated << 11
        | any_radix << 12
    )


def named(name: str) -> int:
    """Return the word of a formatter by its PBASIC name."""
    if name in ("NUM", "SNUM"):
        return {"NUM": 0x1106, "SNUM": 0x1506}[name]
    base = name.rstrip("0123456789")
    digits = int(name[len(base) :] or 0)
    stem = base[-3:]
    return word(
        {"DEC": 10, "HEX": 16, "BIN": 2}[stem],
        digits,
        signed=base.startswith(("S", "IS")),
        indicated=base.startswith("I"),
    )


def read(name: str, text: str) -> int | None:
    """Read a text as SERIN does; None where the number is not complete at its end."""
    reader = NumberReader(named(name))
    for byte in text.encode("latin-1"):
        if reader.take(byte):
            return reader.value
    return None


def test_words_are_the_tokenizers() -> None:
    """S3: what the tokenizer makes of DEC, DEC3, SDEC, HEX, HEX2, IHEX4, ISBIN16, BIN, BIN8."""
    words = {
        "DEC": 0x01B6, "DEC3": 0x03D6, "SDEC": 0x05B6, "HEX": 0x01C0, "HEX2": 0x03E0,
        "IHEX4": 0x0BC0, "ISBIN16": 0x0F0E, "BIN": 0x010E, "BIN8": 0x038E,
    }  # fmt: skip
    assert {name: named(name) for name in words} == words


SENT = [
    # S2 p. 164 and 166: what DEBUG shows of x = -65
    ("SDEC", 65471, "-65"), ("ISHEX", 65471, "-$41"), ("ISBIN", 65471, "-%1000001"),
    ("DEC", 65471, "65471"), ("IHEX", 65471, "$FFBF"), ("IBIN", 65471, "%1111111110111111"),
    ("SDEC5", 65471, "-00065"), ("ISHEX4", 65471, "-$0041"),
    ("ISBIN16", 65471, "-%0000000001000001"),
    # S2 p. 165 and 166: fixed digits pad, and drop leading ones
    ("DEC5", 165, "00165"), ("DEC4", 165, "0165"), ("DEC3", 165, "165"), ("DEC2", 165, "65"),
    ("DEC4", 65, "0065"), ("DEC4", 56422, "6422"),
    # S2 p. 164: a space is the sign of what is not negative; p. 160: IHEX of 65
    ("SDEC", 65, " 65"), ("IHEX", 65, "$41"), ("HEX", 65, "41"), ("BIN", 65, "1000001"),
    # two's complement at its ends
    ("SDEC", 0x8000, "-32768"), ("SDEC", 0x7FFF, " 32767"), ("SDEC", 0, " 0"), ("DEC", 0, "0"),
    ("SHEX", 0xFFFF, "-1"), ("BIN4", 0xFFFF, "1111"), ("HEX1", 0xABCD, "D"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "value", "text"), SENT)
def test_what_is_sent(name: str, value: int, text: str) -> None:
    assert text_of(named(name), value).decode() == text


# S2 appendix C: characters received across the top, formatters down the side; "x" stands for
# any character that is no numeric, "--" for a number that is not complete.
TABLES = [
    (
        10,
        ["x", "123", "123x", "-123x", "x123x", "12345x", "65536x", "255255x"],
        """
        DEC   -- --  123 123  123 12345 0    58647
        DEC1  -- 1   1   1    1   1     6    2
        DEC2  -- 12  12  12   12  12    65   25
        DEC3  -- 123 123 123  123 123   655  255
        DEC4  -- --  123 123  123 1234  6553 2552
        DEC5  -- --  123 123  123 12345 0    25525
        SDEC  -- --  123 -123 123 12345 0    -6889
        SDEC1 -- 1   1   -1   1   1     6    2
        SDEC2 -- 12  12  -12  12  12    65   25
        SDEC3 -- 123 123 -123 123 123   655  255
        SDEC4 -- --  123 -123 123 1234  6553 2552
        SDEC5 -- --  123 -123 123 12345 0    25525
        """,
    ),
    (
        16,
        ["x", "1F", "1Fx", "-1Fx", "x1Fx", "15AFx", "10000x", "3E517x"],
        """
        HEX   -- -- 1F 1F  1F 15AF 0    E517
        HEX1  -- 1  1  1   1  1    1    3
        HEX2  -- 1F 1F 1F  1F 15   10   3E
        HEX3  -- -- 1F 1F  1F 15A  100  3E5
        HEX4  -- -- 1F 1F  1F 15AF 1000 3E51
        SHEX  -- -- 1F -1F 1F 15AF 0    -1AE9
        SHEX1 -- 1  1  -1  1  1    1    3
        SHEX2 -- 1F 1F -1F 1F 15   10   3E
        SHEX3 -- -- 1F -1F 1F 15A  100  3E5
        SHEX4 -- -- 1F -1F 1F 15AF 1000 3E51
        """,
    ),
    (
        16,
        ["x", "1F", "1Fx", "$1F", "$1Fx", "-$1Fx", "x$1Fx", "$15AFx"],
        """
        IHEX   -- -- -- -- 1F 1F  1F 15AF
        IHEX1  -- -- -- 1  1  1   1  1
        IHEX2  -- -- -- 1F 1F 1F  1F 15
        IHEX3  -- -- -- -- 1F 1F  1F 15A
        IHEX4  -- -- -- -- 1F 1F  1F 15AF
        ISHEX  -- -- -- -- 1F -1F 1F 15AF
        ISHEX1 -- -- -- 1  1  -1  1  1
        ISHEX2 -- -- -- 1F 1F -1F 1F 15
        ISHEX3 -- -- -- -- 1F -1F 1F 15A
        ISHEX4 -- -- -- -- 1F -1F 1F 15AF
        """,
    ),
    (
        2,
        ["x", "11", "11x", "-11x", "x11x", "101x", "3E517x"],
        """
        BIN    -- -- 11 11  11 101 1
        BIN1   -- 1  1  1   1  1   1
        BIN2   -- 11 11 11  11 10  1
        BIN3   -- -- 11 11  11 101 1
        BIN16  -- -- 11 11  11 101 1
        SBIN   -- -- 11 -11 11 101 1
        SBIN1  -- 1  1  -1  1  1   1
        SBIN2  -- 11 11 -11 11 10  1
        SBIN16 -- -- 11 -11 11 101 1
        """,
    ),
]
CELLS = [
    (name, text, None if cell == "--" else int(cell, radix) & 0xFFFF)
    for radix, texts, table in TABLES
    for name, *cells in (line.split() for line in table.strip().splitlines())
    for text, cell in zip(texts, cells, strict=True)
]


@pytest.mark.parametrize(("name", "text", "value"), CELLS)
def test_appendix_c(name: str, text: str, value: int | None) -> None:
    for other in "x \rg":
        assert read(name, text.replace("x", other)) == value


@pytest.mark.parametrize(
    ("name", "text", "value"),
    [
        # S2 p. 403, note 2: the minus stands directly before the number
        ("SDEC", "- 5,", 5), ("SDEC", "a-b5,", 5), ("SDEC", "--5,", 0xFFFB),
        # note 3: hexadecimal digits of either case
        ("HEX", "aBc,", 0xABC), ("IHEX2", "$fF", 0xFF),
        # note 4: the indicator, too, and what is not indicated is no number
        ("IHEX", "ABC $ A $B,", 0xB), ("IBIN", "10 %10,", 2), ("ISHEX", "-x$F,", 0xF),
        ("ISHEX", "$-F$-$1,", 0xFFFF), ("IHEX", "$$5,", 5), ("ISHEX", "-$$5,", 5),
        # p. 403: NUM takes decimal numbers, and others where they are indicated
        ("NUM", "12,", 12), ("NUM", "$12,", 0x12), ("NUM", "%12,", 1), ("NUM", "A12,", 12),
        ("NUM", "12A", 12), ("NUM", "$1Fx", 0x1F), ("NUM", "-5,", 5), ("NUM", "%5,", 5),
        ("SNUM", "-12,", 0xFFF4), ("SNUM", "-$12,", 0xFFEE), ("SNUM", "-%11,", 0xFFFD),
        ("SNUM", "-32768,", 0x8000), ("NUM", "$ 12,", 12),
        # a number ends with the first byte behind it, and not before
        ("DEC", "0,", 0), ("DEC", "000000007", None),
    ],
)  # fmt: skip
def test_what_counts_as_a_number(name: str, text: str, value: int | None) -> None:
    assert read(name, text) == value


def test_radix_1_is_refused() -> None:
    with pytest.raises(ExecutionError, match="010Fh"):
        format_of(0x010F)


FORMATS = [
    prefix + stem + digits
    for stem, most in (("DEC", 5), ("HEX", 4), ("BIN", 16))
    for digits in ("", str(most))
    for prefix in (("", "S") if stem == "DEC" else ("", "S", "I", "IS"))
]


@pytest.mark.parametrize("name", FORMATS)
@given(value=st.integers(0, 0xFFFF))
def test_what_is_sent_is_read_again(name: str, value: int) -> None:
    assert read(name, text_of(named(name), value).decode() + ",") == value


@given(st.binary(max_size=40), st.integers(0, 0x1FFF).filter(lambda w: w & 15 != 15))
def test_any_bytes_and_any_word_give_a_word(data: bytes, formatter: int) -> None:
    reader = NumberReader(formatter)
    for byte in data:
        if reader.take(byte):
            break
    assert 0 <= reader.value <= 0xFFFF
    assert text_of(formatter, reader.value)
