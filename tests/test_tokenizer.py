"""The tokenizer: every vector byte for byte, every refusal in its place, every defect hidden."""

import json
import os
import signal
import subprocess
import sys
import threading
import time
import warnings
from collections.abc import Iterator
from importlib import resources
from pathlib import Path
from typing import Any

import pytest

from cgagen.cli import main
from cgagen.errors import SourceError, ToolchainError
from cgagen.stamp.packets import packets_of
from cgagen.tokenizer import Tokenizer, compile_source
from cgagen.toolchain import TOKENIZER_SHA256, find_node, find_tokenizer

VECTORS = json.loads((Path(__file__).parent / "vectors" / "tokens.json").read_text())
HEAD = "' {$STAMP BS2}\n' {$PBASIC 2.5}\n"
LED = "' {$STAMP BS2}\nHIGH 3\n"
LED_TAIL = bytes.fromhex("140e07c0")


@pytest.fixture
def own() -> Iterator[Tokenizer]:
    """A tokenizer of one's own, to be killed."""
    with Tokenizer() as tokenizer:
        yield tokenizer


def test_there_are_91_vectors() -> None:
    assert len({vector["id"] for vector in VECTORS}) == 91


@pytest.mark.parametrize("vector", VECTORS, ids=lambda vector: str(vector["id"]))
def test_a_vector_reproduces(tokenizer: Tokenizer, vector: dict[str, Any]) -> None:
    compiled = tokenizer.compile(vector["source"], vector["id"])
    eeprom = bytearray(2048)
    tail = bytes.fromhex(vector["program_tail_hex"])
    eeprom[2048 - len(tail) :] = tail
    for address, byte in vector["data_bytes"].items():
        eeprom[int(address)] = int(byte, 16)
    assert compiled.image.model.directive == vector["model"]
    assert compiled.image.eeprom == bytes(eeprom)
    assert [packet.hex() for packet in packets_of(compiled.image)] == vector["packets"]
    assert list(compiled.variables) == vector["var_counts"]
    assert compiled.start_bit == vector["start_bit"]
    assert compiled.gosub_slots == vector["start_bit"] // 14 - 1
    assert compiled.program_bytes == vector["program_bytes"]
    rows = compiled.source_map.statements
    assert [[row.offset, row.bit] for row in rows] == vector["xref"]
    lines = vector["source"].split("\n")
    for row in rows:
        assert vector["source"][row.offset :].startswith(lines[row.line - 1][row.column - 1 :])


REFUSED = [
    # (source after HEAD, code, line, column, length, words)
    ("x VAR Word\nx = foo + 1\n", 110, 4, 5, 3, "Undefined symbol (foo)"),
    ("foo = 1\n", 174, 3, 1, 3, "Label is missing ':' (foo)"),
    ("PUT 1, 2\n", 174, 3, 1, 3, "(PUT)"),
    ("GOTO nowhere\n", 111, 3, 6, 7, "Undefined label (nowhere)"),
    ("d DATA (2049)\n", 114, 3, 9, 4, "Location is out of range (2049)"),
    ("w VAR Word(14)\n", 126, 3, 12, 2, "Out of variable space (14)"),
    ("i VAR Nib\nFOR i = 0 TO 3\n", 169, 4, 1, 3, "'FOR' without 'NEXT' (FOR)"),
    ("DO\n", 170, 3, 1, 2, "'DO' without 'LOOP'"),
    ("IF IN0 = 1 THEN\n", 168, 3, 1, 2, "'IF' without 'ENDIF'"),
    ("NEXT\n", 132, 3, 1, 4, "(NEXT)"),
    ("LOOP\n", 164, 3, 1, 4, "(LOOP)"),
    ("ENDIF\n", 160, 3, 1, 5, "(ENDIF)"),
    ("a CON 70000\n", 109, 3, 7, 6, "Constant exceeds 16 bits (70000)"),
    ("a23456789012345678901234567890123:\n", 106, 3, 1, 33, "Symbol exceeds 32 characters"),
    ("x PIN 16\n", 175, 3, 7, 2, "Pin number"),
    ("x VAR Word\nx = 1 / 0 CON\n", None, 4, None, None, ""),
    ("HIGH 1\r\n\r\n  HIGH foo\r\n", 110, 5, 8, 3, "(foo)"),
    ("HIGH 1\r\rHIGH foo\r", 110, 5, 6, 3, "(foo)"),
    ("a:\nGOSUB a\n" * 1 + "GOSUB a\n" * 255, 145, 259, 1, 5, "Limit of 255 GOSUBs exceeded"),
    ('#ERROR "too many"\n', 199, 3, 1, 17, "199-too many"),
]


@pytest.mark.parametrize(
    ("rest", "code", "line", "column", "length", "words"), REFUSED, ids=lambda case: repr(case)[:20]
)
def test_a_refusal_has_its_place(
    tokenizer: Tokenizer,
    rest: str,
    code: int | None,
    line: int,
    column: int | None,
    length: int | None,
    words: str,
) -> None:
    with pytest.raises(SourceError) as caught:
        tokenizer.compile(HEAD + rest, "main.bsp")
    error = caught.value
    assert error.line == line
    assert code is None or (error.code, error.column, error.length) == (code, column, length)
    assert str(error).startswith(f"main.bsp:{error.line}:{error.column}: {error.code}-")
    assert words in str(error)
    assert "\n" not in str(error)


@pytest.mark.parametrize(
    ("source", "code"),
    [
        (HEAD + "d DATA @2030, 1, 2, 3\n" + "HIGH 1\n" * 20, 124),
        (HEAD + "".join(f"c{n} CON {n}\n" for n in range(1100)) + "HIGH 1\n", 128),
        ("HIGH 1\n", 156),
        ("", 156),
        (HEAD + "' nothing\n", 157),
    ],
)
def test_an_error_without_a_place_names_no_line(
    tokenizer: Tokenizer, source: str, code: int
) -> None:
    with pytest.raises(SourceError) as caught:
        tokenizer.compile(source, "main.bsp")
    assert (caught.value.code, caught.value.line, caught.value.column) == (code, None, None)
    assert str(caught.value).startswith(f"main.bsp: {code}-")


def test_other_targets_are_refused_where_they_are_named(tokenizer: Tokenizer) -> None:
    with pytest.raises(SourceError, match=r"p:1:11: 204-.*\(BS1\)"):
        tokenizer.compile("' {$STAMP BS1}\nHIGH 1\n", "p")
    with pytest.raises(SourceError, match=r"p:2:12: 187-"):
        tokenizer.compile("' {$STAMP BS2}\n' {$PBASIC 3.0}\nHIGH 1\n", "p")


def test_a_full_eeprom_and_too_many_elements_are_located(tokenizer: Tokenizer) -> None:
    with pytest.raises(SourceError) as full:
        tokenizer.compile(HEAD + "PULSOUT 1, 1000\n" * 800)
    assert full.value.code == 127
    assert full.value.line is not None
    assert full.value.line > 400
    with pytest.raises(SourceError, match="107-Too many elements"):
        tokenizer.compile(HEAD + "x VAR Word\n" + "x=x+1\n" * 2200)


# --- silent changes -------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("rest", "line", "column", "words"),
    [
        ('DEBUG "caf\u00e9"\n', 3, 11, "U+00E9"),
        ('DEBUG "\u03c0"\n', 3, 8, "U+03C0"),
        ("HIGH 1\x00\nHIGH 2\n", 3, 7, "control character 0"),
        ("HIGH 1\n\tHIGH\x032\n", 4, 6, "control character 3"),
        ("HIGH 1 ' bell \x07\n", 3, 15, "control character 7"),
        ("HIGH 1 ' {$PORT COM\u00e9}\n", 3, 20, "U+00E9"),
        ("H\u0130GH 1\n", 3, 2, "U+0130"),
        ("HIGH 1\x7f\n", 3, 7, "control character 127"),
        ('DEBUG "\ud800"\n', 3, 8, "U+D800"),
    ],
)
def test_what_would_change_silently_is_refused(
    tokenizer: Tokenizer, rest: str, line: int, column: int, words: str
) -> None:
    with pytest.raises(SourceError) as caught:
        tokenizer.compile(HEAD + rest, "p")
    assert (caught.value.line, caught.value.column, caught.value.code) == (line, column, 0)
    assert words in str(caught.value)
    str(caught.value).encode()  # can be printed


def test_foreign_letters_in_comments_change_nothing(tokenizer: Tokenizer) -> None:
    plain = tokenizer.compile(HEAD + "HIGH 3 ' 5 us\n")
    foreign = tokenizer.compile(HEAD + "HIGH 3 ' 5 \u00b5s \U0001f916\n")
    assert foreign.image.eeprom == plain.image.eeprom
    assert foreign.source.endswith("\U0001f916\n")


@pytest.mark.parametrize("size", [65_535, 65_536, 4_000_000])
def test_a_source_that_cannot_be_numbered_is_refused(tokenizer: Tokenizer, size: int) -> None:
    source = LED + "'" * (size - len(LED) - 1) + "\n"
    if size == 65_535:
        assert tokenizer.compile(source).image.eeprom.endswith(LED_TAIL)
    else:
        with pytest.raises(SourceError, match="65,535"):
            tokenizer.compile(source, "long.bs2")


@pytest.mark.parametrize(
    "rest",
    [
        "HIGH 16",
        "x CON 16\nHIGH x",
        "IF IN0 = 1 THEN LOW 16",
        "PULSOUT 16, 5",
        "PULSIN 65535, 1, B0",
        "RCTIME 16, 1, W0",
        "COUNT 16, 1, W0",
        "PWM 16, 1, 1",
        "FREQOUT 16, 1, 1",
        "FREQOUT 16, 1, 1, 1",
        "DTMFOUT 16, [1]",
        "XOUT 1, 16, [0\\1]",
        "SHIFTOUT 16, 1, 0, [1]",
        "SHIFTIN 1, 16, 0, [B0]",
        "BUTTON 16, 0, 0, 0, B0, 0, x\nx:",
        "SEROUT 17, 84, [1]",
        "SEROUT 1\\16, 84, [1]",
        "SERIN 17, 84, [B0]",
        "INPUT 20",
        "TOGGLE 16",
    ],
)
def test_a_pin_that_no_chip_has_is_refused(tokenizer: Tokenizer, rest: str) -> None:
    with pytest.raises(SourceError, match=r"p:\d+:\d+: [A-Z]+ names pin \d+; give one of 0 to"):
        tokenizer.compile(HEAD + rest + "\n", "p")


@pytest.mark.parametrize(
    "rest",
    [
        "LCDCMD 16, 1",
        "LCDOUT 16, 1, [1]",
        "I2COUT 16, 1, 1, [1]",
        "OWOUT 16, 1, [1]",
        "POLLIN 16, 1",
    ],
)
def test_pins_of_the_bs2p_are_judged_too(tokenizer: Tokenizer, rest: str) -> None:
    with pytest.raises(SourceError, match="names pin 16"):
        tokenizer.compile(HEAD.replace("BS2}", "BS2p}") + rest + "\n", "p")


@pytest.mark.parametrize(
    "rest",
    [
        "HIGH 15",
        "SEROUT 16, 84, [16]",
        "SERIN 16, 84, [B0]",
        "SERIN 16\\15, 84, [B0]",
        "SEROUT 16, 84, 100, [1]",
        "HIGH B0 + 16",
        "HIGH 8 + 8",  # computed at run time
        'DEBUG "HIGH 16", CR',
        "PULSOUT 15, 65535",
        "FREQOUT 1, 16, 17, 18",
        "OUTS = 16",
        "x CON 16\nDEBUG DEC x",
        "IF IN0 = 16 THEN HIGH 1",
        "FOR B0 = 16 TO 20 : HIGH B0 : NEXT",
        "SHIFTOUT 1, 2, 0, [16\\16]",
        "XOUT 1, 2, [16\\17]",
    ],
)
def test_legal_pins_raise_no_alarm(tokenizer: Tokenizer, rest: str) -> None:
    assert tokenizer.compile(HEAD + rest + "\n").program_bytes > 0


# --- a process that leaks, hangs, dies -------------------------------------------------------


@pytest.mark.parametrize("end", ["'", "' ", "'\t ", "END\n'", "END\n' ", "' abc"])
def test_a_comment_at_the_very_end_does_not_hang(tokenizer: Tokenizer, end: str) -> None:
    assert tokenizer.compile(LED + end).image.eeprom.endswith(LED_TAIL)


def test_no_source_costs_memory_for_ever(own: Tokenizer) -> None:
    # 400 times 60 kB is more than the whole 16 MB heap of the tokenizer.
    big = LED + ("'" + "x" * 98 + "\n") * 600
    first = own.compile(big).image
    pid = own.pid
    for _ in range(400):
        assert own.compile(big).image == first
    assert own.pid == pid


def test_one_program_leaves_no_trace_in_the_next(own: Tokenizer) -> None:
    before = own.compile(LED)
    for spoil in (HEAD + "DO\n" * 20, HEAD + "#DEFINE a = 1\nfoo", HEAD + "PULSOUT 1,1\n" * 900):
        with pytest.raises(SourceError):
            own.compile(spoil)
        assert own.compile(LED) == before


def test_the_source_map_holds_the_longest_program(tokenizer: Tokenizer) -> None:
    # 7 bits a statement is the least: 16,384 bits, less a header of 14 and the final END.
    rows = tokenizer.compile(HEAD + "STOP\n" * 2337).source_map.statements
    assert [row.bit for row in rows] == list(range(14, 14 + 7 * 2337, 7))
    assert [row.line for row in rows] == list(range(3, 2340))


def test_a_killed_process_is_replaced(own: Tokenizer) -> None:
    first = own.compile(LED)
    pid = own.pid
    assert pid is not None
    os.kill(pid, signal.SIGKILL)
    assert own.compile(LED) == first
    assert own.pid not in (None, pid)


def test_a_kill_in_mid_use_costs_nothing(own: Tokenizer) -> None:
    expected = own.compile(LED)
    done = threading.Event()

    def killer() -> None:
        for _ in range(3):
            pid = own.pid
            if pid is not None:
                os.kill(pid, signal.SIGKILL)
            done.wait(0.2)
        done.set()

    thread = threading.Thread(target=killer)
    thread.start()
    rounds = 0
    while not done.is_set():
        assert own.compile(LED) == expected
        rounds += 1
    thread.join()
    assert rounds > 0


def fake(script: str) -> list[str]:
    return [sys.executable, "-u", "-c", script]


def test_a_process_that_does_not_answer_is_stopped() -> None:
    command = fake("import time; print('{\"ready\": 1}'); time.sleep(600)")
    with Tokenizer(0.2, command=command) as tokenizer:
        with pytest.raises(ToolchainError, match=r"slow\.bs2: .* no answer in 0\.2 s"):
            tokenizer.compile(LED, "slow.bs2")
        assert tokenizer.pid is None


def test_a_process_that_does_not_read_is_stopped() -> None:
    command = fake("import time; print('{\"ready\": 1}'); time.sleep(600)")
    big = LED + "'" * 65_000 + "\n"
    with Tokenizer(0.2, command=command) as tokenizer:
        for _ in range(2):  # 65 kB is more than a pipe holds
            with pytest.raises(ToolchainError, match="no answer"):
                tokenizer.compile(big)


@pytest.mark.parametrize(
    ("script", "words"),
    [
        ("print('{\"ready\": 1}'); input()", "died twice"),
        ("print('{\"ready\": 1}'); input(); print('no JSON'); input()", "died twice .*JSON"),
        ("print('{\"ready\": 1}'); input(); print('{\"id\": 99}'); input()", "out of turn"),
        ('print(\'{"ready": 1}\'); input(); print(\'{"id": 1, "fatal": "abort"}\')', "abort"),
        ("raise SystemExit(1)", "did not start"),
        ('print(\'{"fatal": "hash 00"}\')', "hash 00"),
        ("print('[]')", "did not start"),
        ("raise ValueError('odd machine')", "ValueError: odd machine"),
    ],
)
def test_a_sick_process_is_one_sentence(script: str, words: str) -> None:
    with Tokenizer(5, command=fake(script)) as tokenizer:
        with pytest.raises(ToolchainError, match=words) as caught:
            tokenizer.compile(LED)
        assert "\n" not in str(caught.value)


def test_a_program_that_is_not_there_is_one_sentence() -> None:
    with (
        Tokenizer(command=["/nonexistent/node"]) as tokenizer,
        pytest.raises(ToolchainError, match="does not start"),
    ):
        tokenizer.compile(LED)


def test_a_fork_gets_its_own_process(own: Tokenizer) -> None:
    expected = own.compile(LED)
    mine = own.pid
    reading, writing = os.pipe()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # Python 3.12: fork beside threads
        child = os.fork()
    if child == 0:  # pragma: no cover - another process
        verdict = b"bad"
        try:
            good = own.compile(LED) == expected and own.pid not in (None, mine)
            own.close()
            verdict = b"good" if good else b"same"
        finally:
            os.write(writing, verdict)
            os._exit(0)
    os.close(writing)
    with os.fdopen(reading, "rb") as pipe:
        assert pipe.read() == b"good"
    os.waitpid(child, 0)
    assert own.compile(LED) == expected
    assert own.pid == mine


def test_threads_take_turns(own: Tokenizer) -> None:
    sources = [f"' {{$STAMP BS2}}\nHIGH {pin}\n" for pin in range(8)]
    expected = [own.compile(source).image for source in sources]
    seen: dict[int, list[bool]] = {}

    def work(index: int) -> None:
        seen[index] = [own.compile(sources[index]).image == expected[index] for _ in range(20)]

    threads = [threading.Thread(target=work, args=(index,)) for index in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(all(seen[index]) and len(seen[index]) == 20 for index in range(8))


def test_the_process_ends_with_its_owner() -> None:
    script = (
        "from cgagen.tokenizer import Tokenizer\n"
        't = Tokenizer(); t.compile("\' {$STAMP BS2}\\nHIGH 3\\n"); print(t.pid, flush=True)\n'
        "import time; time.sleep(600)"
    )
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE) as owner:
        assert owner.stdout is not None
        worker = int(owner.stdout.readline())
        group = os.getpgid(worker)
        owner.kill()
        owner.wait()
    assert group == worker  # so Ctrl-C on a terminal does not reach it
    for _ in range(500):
        if not _alive(worker):
            break
        time.sleep(0.02)
    assert not _alive(worker)


def _alive(pid: int) -> bool:
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return False
    return state != "Z"


def test_a_closed_tokenizer_says_so(own: Tokenizer) -> None:
    own.compile(LED)
    own.close()
    own.close()
    with pytest.raises(ValueError, match="closed"):
        own.compile(LED)


def test_the_worker_warns_of_nothing_and_keeps_no_handler(tmp_path: Path) -> None:
    hook = tmp_path / "hook.cjs"
    hook.write_text(
        "process.on('exit', () => console.error(process.listenerCount('uncaughtException')))"
    )
    worker = str(resources.files("cgagen.tokenizer") / "worker.cjs")
    done = subprocess.run(
        [find_node().path, "-r", hook, worker, find_tokenizer(), TOKENIZER_SHA256],
        input=json.dumps({"id": 1, "source": LED}) + "\n",
        capture_output=True,
        text=True,
        check=True,
        env={key: value for key, value in os.environ.items() if not key.startswith("NODE_")},
    )
    assert [json.loads(line).get("ok") for line in done.stdout.splitlines()] == [None, True]
    assert done.stderr.split() == ["0"]


# --- what else a source says -----------------------------------------------------------------


def test_further_files_and_the_port_are_reported(tokenizer: Tokenizer) -> None:
    compiled = tokenizer.compile(
        "' {$STAMP BS2p, sensors.bsp, \"two words.bsp\"}\n' {$PORT COM3}\nHIGH 1\n"
    )
    assert compiled.project_files == ("sensors.bsp", "two words.bsp")
    assert (compiled.port, compiled.language, compiled.debugs) == ("COM3", 200, False)
    assert tokenizer.compile(HEAD + 'DEBUG "x"').debugs


def test_one_tokenizer_is_shared() -> None:
    assert compile_source(LED) == compile_source(LED)


# --- the verb ----------------------------------------------------------------------------------


@pytest.fixture
def led(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "led.bs2"
    path.write_bytes(LED.encode())
    return path


def test_compile_writes_image_and_map(led: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["compile", "led.bs2", "-o", "led.bin", "--map", "led.map"]
    assert main(words) == main(words) == 0  # our own files may be replaced
    out = capsys.readouterr()
    assert "program                      5 bytes" in out.out
    image = (led.parent / "led.bin").read_bytes()
    assert (len(image), image[-4:]) == (2048, LED_TAIL)
    assert (led.parent / "led.map").read_text() == "line,column,bit\n2,1,14\n"


def test_compile_tells_everything_as_json(led: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--json", "compile", "led.bs2"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert bytes.fromhex(data["eeprom"])[-4:] == LED_TAIL
    assert data["packets"] == ["ff" + "00" * 11 + "00140e07c018"]
    assert data["source_map"] == [{"offset": 15, "line": 2, "column": 1, "bit": 14}]
    assert (data["model"], data["memory"]["free_bytes"]) == ("BS2", 2043)
    assert set(bytes.fromhex(data["flags"])) == {0, 0x80, 0x83}


@pytest.mark.parametrize("option", ["-o", "--map"])
def test_compile_overwrites_nothing_of_the_users(
    led: Path, capsys: pytest.CaptureFixture[str], option: str
) -> None:
    precious = led.with_name("thesis.txt")
    precious.write_text("years of work")
    assert main(["compile", "led.bs2", option, "thesis.txt"]) == 3
    assert "--force" in capsys.readouterr().err
    assert precious.read_text() == "years of work"
    assert main(["compile", "led.bs2", option, "led.bs2", "--force"]) == 2
    assert led.read_bytes() == LED.encode()
    assert main(["compile", "led.bs2", option, "thesis.txt", "--force"]) == 0
    assert precious.read_bytes() != b"years of work"


def test_a_refused_source_writes_nothing(led: Path, capsys: pytest.CaptureFixture[str]) -> None:
    led.write_text(HEAD + "HIGH foo\n")
    assert main(["compile", "led.bs2", "-o", "led.bin"]) == 6
    assert capsys.readouterr().err == "cgagen: led.bs2:3:6: 110-Undefined symbol (foo)\n"
    assert [path.name for path in led.parent.iterdir()] == ["led.bs2"]


@pytest.mark.parametrize(
    ("content", "code", "words"),
    [
        (b"\xef\xbb\xbf" + LED.encode(), 0, ""),  # a mark that some editors put first
        (LED.encode() + b"' 5 \xb5s\n", 0, ""),  # Windows-1252
        (LED.encode() + "' 5 \u00b5s\n".encode(), 0, ""),
        (LED.encode("utf-16"), 6, "silently"),
        (bytes(range(256)), 6, "silently"),
        (b"", 6, "156"),
    ],
)
def test_any_file_is_compiled_or_refused(
    led: Path, capsys: pytest.CaptureFixture[str], content: bytes, code: int, words: str
) -> None:
    led.write_bytes(content)
    assert main(["compile", "led.bs2"]) == code
    assert words in capsys.readouterr().err


def test_a_source_that_is_not_there(led: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["compile", "lad.bs2"]) == 6
    assert "lad.bs2: cannot be read (No such file" in capsys.readouterr().err


def test_further_files_are_named_in_a_note(led: Path, capsys: pytest.CaptureFixture[str]) -> None:
    led.write_text("' {$STAMP BS2e, more.bse}\nHIGH 1\n")
    assert main(["compile", "led.bs2"]) == 0
    assert "more.bse" in capsys.readouterr().err
