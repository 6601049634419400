"""`cgagen emulate` as a user calls it: what can be run, how it ends, and what goes in."""

import json
import re
import time

import pytest

from cgagen.emulator.conversation import Conversation
from cgagen.emulator.programs import bench_of_sources
from cgagen.emulator.session import Why, run_session
from cgagen.tokenizer import Tokenizer
from cgagen.tokenizer.files import write_image
from tests.emulate_cases import BASIC, ENDLESS, PREDATOR, PROGRAMS, Emulate, Program


def test_a_source(emulate: Emulate) -> None:
    assert emulate(PROGRAMS / "hello.bs2", "--expect-end") == (0, "Hello, Stamp!\r", "")


def test_a_source_with_further_slots(emulate: Emulate) -> None:
    code, out, err = emulate(PROGRAMS / "run_slots.bs2", "--expect-end")
    assert (code, err) == (0, "")
    assert out.endswith("fleas = 259\r")


def test_a_bench(emulate: Emulate) -> None:
    assert emulate(PROGRAMS / "count.toml", "--expect-end") == (0, "0\r12\r", "")


def test_another_chip_of_a_bench(emulate: Emulate, program: Program) -> None:
    program(BASIC + 'DEBUG "one"\n', "one.bs2")
    program(BASIC + 'PAUSE 20\nDEBUG "two"\n', "two.bs2")
    bench = program(
        'format = "cgagen-bench-1"\n[chip.first]\nsource = "one.bs2"\n'
        '[chip.second]\nsource = "two.bs2"\n',
        "bench.toml",
    )
    assert emulate(bench) == (0, "one", "")
    assert emulate(bench, "--chip", "second") == (0, "two", "")
    code, out, err = emulate(bench, "--chip", "seconds")
    assert (code, out, err.count("\n")) == (3, "", 1)
    assert "did you mean second?" in err


def test_an_image_beside_its_source(
    emulate: Emulate, program: Program, tokenizer: Tokenizer
) -> None:
    source = program(BASIC + "DEBUG BIN1 IN3, CR\n")
    image = source.with_suffix(".bin")
    write_image(image, tokenizer.compile(source.read_text()).image)
    code, out, err = emulate(image)
    assert (code, out) == (0, "0\r")
    assert "it.bs2:3: P3 is read" in err
    source.unlink()
    code, out, err = emulate(image)
    assert (code, out) == (2, "")
    assert "--model" in err
    code, out, err = emulate(image, "--model", "bs2")
    assert (code, out) == (0, "0\r")
    assert "main: P3 is read" in err


def test_an_image_of_a_build_knows_its_model(emulate: Emulate) -> None:
    code, out, _ = emulate(PREDATOR / "main.bin", "--for", "300ms")
    assert (code, out[:22]) == (0, "#1 M servobot-predator")


def test_the_bench_of_a_build(emulate: Emulate) -> None:
    code, out, err = emulate(PREDATOR / "bench.toml", "--for", "5s")
    assert (code, err) == (0, "")
    assert re.search(r":0 F\d+ R\d+ L\d+ .*C\d", out)


# -- Ends, times, exit codes ------------------------------------------------------------------


@pytest.mark.parametrize(
    ("words", "milliseconds"), [(("--for", "250ms"), 250), (("--for", "0.25s"), 250), ((), 10_000)]
)
def test_the_time_is_over(
    words: tuple[str, ...], milliseconds: int, emulate: Emulate, program: Program
) -> None:
    code, out, _ = emulate(program(ENDLESS), "--json", *words)
    data = json.loads(out)
    assert (code, data["ended"], data["time_ns"]) == (0, "TIME", milliseconds * 1_000_000)
    dots = milliseconds / 102
    assert dots - 3 < len(data["output"]) < dots + 2


@pytest.mark.parametrize("word", ["END", "STOP"])
def test_the_time_of_an_end_is_its_own(word: str, emulate: Emulate, program: Program) -> None:
    data = json.loads(emulate(program(BASIC + f"PAUSE 7\n{word}\n"), "--json")[1])
    assert data["ended"] == word
    assert 7_000_000 < data["time_ns"] < 7_500_000


def test_no_end_where_one_is_expected(emulate: Emulate, program: Program) -> None:
    code, _, err = emulate(program(ENDLESS), "--for", "250ms", "--expect-end")
    assert code == 9
    assert "no END or STOP in 0.25 s" in err
    code, _, err = emulate(program(BASIC + "DO\nLOOP\n"), "--until-end", "--expect-end")
    assert code == 9
    assert "empty loop at" in err
    assert "it.bs2:4" in err


def test_an_empty_loop_lasts_as_long_as_it_may(emulate: Emulate, program: Program) -> None:
    loop = program(BASIC + "DO\nLOOP\n")
    data = json.loads(emulate(loop, "--json", "--for", "2s")[1])
    assert (data["ended"], data["time_ns"]) == ("LOOP", 2_000_000_000)
    program(BASIC + 'PAUSE 400\nDEBUG "b"\nDO\n  PAUSE 100\nLOOP\n', "b.bs2")
    bench = program(
        'format = "cgagen-bench-1"\n[chip.main]\nsource = "it.bs2"\n[chip.b]\nsource = "b.bs2"\n',
        "bench.toml",
    )
    assert emulate(bench, "--chip", "b", "--for", "500ms") == (0, "b", "")
    data = json.loads(emulate(bench, "--json", "--for", "500ms")[1])
    assert (data["ended"], data["time_ns"]) == ("LOOP", 500_000_000)
    assert "empty loop at" in emulate(bench, "--for", "500ms", "--expect-end")[2]


def test_stop_is_an_end(emulate: Emulate) -> None:
    code, out, _ = emulate(PROGRAMS / "stop.bs2", "--expect-end", "--json")
    assert (code, json.loads(out)["ended"]) == (0, "STOP")


def test_until_end_goes_past_ten_seconds(emulate: Emulate, program: Program) -> None:
    path = program(BASIC + 'PAUSE 15000\nDEBUG "late"\n')
    code, out, err = emulate(path)
    assert (code, out, err.count("\n")) == (0, "", 1)
    assert "stopped after 10 s of the chip's time" in err
    assert "--until-end" in err
    assert emulate(path, "--until-end") == (0, "late", "")
    assert emulate(path, "--for", "10s") == (0, "", "")


def test_what_nothing_can_bring_is_said(emulate: Emulate, program: Program) -> None:
    path = program(BASIC + 'DEBUG "a"\nSERIN 5, 84, [B0]\n')
    code, out, err = emulate(path, "--until-end", "--pin", "5=1")
    assert (code, out) == (0, "a")
    assert "it.bs2:4: the program waits for P5 to become 0" in err


def test_json_has_everything(emulate: Emulate, program: Program) -> None:
    code, out, err = emulate(program(BASIC + 'DEBUG "a", 200, DEC IN2, CR\n'), "--json")
    data = json.loads(out)
    assert (code, data["output"], data["floating"]) == (0, "a\xc80\r", ["main.P2"])
    assert (data["chip"], data["model"], data["ended"]) == ("main", "BS2", "END")
    assert data["instructions"] == 2
    assert "P2 is read" in err


# -- Pins -------------------------------------------------------------------------------------


def test_a_floating_pin_is_reported_once_with_its_line(emulate: Emulate, program: Program) -> None:
    path = program(BASIC + "FOR B0 = 1 TO 3\n  DEBUG BIN1 IN7\nNEXT\n")
    code, out, err = emulate(path)
    assert (code, out) == (0, "000")
    assert err.count("P7 is read") == 1
    assert "it.bs2:4: P7 is read, and nothing is wired to it: it reads 0" in err


@pytest.mark.parametrize("word", ["7=1", "P7=1", "main.P7=1"])
def test_a_held_pin(word: str, emulate: Emulate, program: Program) -> None:
    path = program(BASIC + "DEBUG BIN1 IN7\nLOW 7\nDEBUG BIN1 IN7\nINPUT 7\nDEBUG BIN1 IN7\n")
    assert emulate(path, "--pin", word) == (0, "101", "")


def test_pins_of_a_bench(emulate: Emulate) -> None:
    """P0 is on a wire with the other chip, which drives it: a resistor changes nothing."""
    assert emulate(PROGRAMS / "count.toml", "--pin", "0=0") == (0, "0\r12\r", "")


@pytest.mark.parametrize(
    "word",
    ["16=1", "3", "3=2", "x=1", "=1", "3=", "-1=1", "nobody.P3=1", "9" * 5_000 + "=1", "\u0663=1"],
)
def test_wrong_pins(word: str, emulate: Emulate) -> None:
    code, out, err = emulate(PROGRAMS / "hello.bs2", "--pin", word)
    assert (code, out) == (3 if "nobody" in word else 2, "")
    assert "Traceback" not in err


# -- Input ------------------------------------------------------------------------------------


def test_input_waits_until_it_is_taken(emulate: Emulate, program: Program) -> None:
    path = program(
        BASIC + "PAUSE 500\nDEBUGIN DEC W0\nPAUSE 500\nDEBUGIN STR B4\\3\nDEBUG DEC W0, STR B4\\3\n"
    )
    assert emulate(path, "--input", "42 xyz", "--expect-end") == (0, "42xyz", "")


def test_in_real_time_input_is_not_held_back(
    emulate: Emulate, program: Program, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(time, "sleep", lambda _: None)
    path = program(BASIC + "PAUSE 500\nSERIN 16, 84, 500, None_, [B0]\nNone_:\nDEBUG DEC B0\n")
    assert emulate(path, "--input", "7") == (0, "55", "")
    assert emulate(path, "--input", "7", "--realtime") == (0, "0", "")


def test_echo(emulate: Emulate, program: Program) -> None:
    path = program(BASIC + 'DEBUG "?"\nDEBUGIN B0\nDEBUG B0 + 1\n')
    assert emulate(path, "--input", "a")[1] == "?b"
    assert emulate(path, "--input", "a", "--echo")[1] == "?ab"


def test_the_end_of_a_line_is_cr(emulate: Emulate, program: Program) -> None:
    path = program(BASIC + "DEBUGIN B0, B1, B2\nDEBUG DEC B0, DEC B1, DEC B2\n")
    assert emulate(path, "--input", "\n\r\nA")[1] == "131365"


def test_input_that_ends_too_early(emulate: Emulate) -> None:
    code, out, err = emulate(PROGRAMS / "debugin_bytes.bs2", "--input", "x", "--expect-end")
    assert (code, out) == (9, "got x\r")
    assert "debugin_bytes.bs2:8: the program waits for input that does not come" in err


# -- Sessions of the library ------------------------------------------------------------------


def test_a_session_repeats_exactly(tokenizer: Tokenizer) -> None:
    compiled = tokenizer.compile((PROGRAMS / "debugin_strings.bs2").read_text())
    typed = (PROGRAMS / "debugin_strings.in").read_bytes()
    seen = []
    for _ in range(2):
        bench = bench_of_sources({0: compiled})
        chip, heard, left = bench.chip("main"), [], [typed]
        conversation = Conversation(
            bench,
            chip,
            lambda byte, heard=heard, bench=bench: heard.append((bench.clock.now_ns, byte)),
            lambda _, left=left: left.pop() if left else None,
        )
        outcome = run_session(bench, chip, conversation)
        assert outcome.why is Why.END
        assert heard
        assert not bench.host("main").unread, "what was shown is kept"
        seen.append((heard, outcome))
    assert seen[0] == seen[1]


def test_lines_may_come_one_by_one(tokenizer: Tokenizer) -> None:
    """DEC skips what is no digit, and wants the next byte within the stop bit of the last."""
    source = BASIC + "DEBUGIN DEC W0, DEC W1, DEC W2\nDEBUG DEC W0, DEC W1, DEC W2\nEND\n"
    bench, seen = bench_of_sources({0: tokenizer.compile(source)}), bytearray()
    typed, asked = [b"a\r", b"12\r", b"\r", b"34", b" 5\r"], []

    def more(needed: bool) -> bytes | None:
        asked.append(needed)
        return typed.pop(0) if typed else None

    chip = bench.chip("main")
    outcome = run_session(bench, chip, Conversation(bench, chip, seen.append, more), 10**9)
    assert (outcome.why, bytes(seen), typed) == (Why.END, b"12345", [])
    assert asked == [True] * 5
