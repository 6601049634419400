"""The DEBUG terminal: echoes taken out, lines in words, what is wrong with a line."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cgagen.bench_protocol import Fault
from cgagen.cli import main
from cgagen.errors import RigError
from cgagen.link import port as port_module
from cgagen.monitor import Decoder, EchoFilter, Listener, listen
from cgagen.monitor.decode import FAULTS
from cgagen.robot import load_robot
from cgagen.telemetry import parse_telemetry, role_in
from cgagen.words import Role
from hil.emulated import robot_bench
from hil.pipe import BytePipe
from hil.subject import read_subject
from tests.subjects import FIRMWARE


class Wire:
    """A port: what is written comes back, if it is wired so, behind what the chip says."""

    def __init__(self, says: list[bytes], echoes: bool = True) -> None:
        self.says = says
        self.echoes = echoes
        self.written = b""
        self.ready = b""

    def read(self, size: int = 1) -> bytes:
        if not self.ready and self.says:
            self.ready = self.says.pop(0)
        data, self.ready = self.ready[:size], self.ready[size:]
        return data

    @property
    def in_waiting(self) -> int:
        return len(self.ready)

    def write(self, data: bytes) -> int:
        self.written += data
        if self.echoes:
            self.ready += data
        return len(data)


def heard(wire: Wire, typed: bytes = b"", turns: int = 40) -> tuple[bytes, list[str]]:
    """Return what a listener hands on, and what it notes."""
    kept, notes, time_s = bytearray(), list[str](), [0.0]

    def now_s() -> float:
        time_s[0] += 0.05
        return time_s[0]

    listener = Listener("COM", wire, [kept.extend], notes.append, now_s)
    texts, left = iter([typed]), [turns]

    def goes_on() -> bool:
        left[0] -= 1
        return left[0] > 0

    listen(listener, lambda: next(texts, None), goes_on)
    assert listener.received == len(kept)
    return bytes(kept), notes


# -- echoes ---------------------------------------------------------------------------------------


def test_what_is_typed_does_not_come_back() -> None:
    wire = Wire([b"ready\r", b"", b"42\r"])
    assert heard(wire, b"six times seven\r") == (b"ready\r42\r", [])
    assert wire.written == b"six times seven\r"


@given(
    said=st.binary(max_size=12),
    typed=st.binary(max_size=6),
    order=st.randoms(use_true_random=False),
)
def test_what_the_chip_says_meanwhile_is_kept(
    said: bytes, typed: bytes, order: "Callable[..., object]"
) -> None:
    """However the echo is mixed in, the bytes are left that the chip has sent, in their order.

    Where both have the same letter, nobody can say whose is the first.
    """
    echo, mixed, left, right = EchoFilter(), bytearray(), list(said), list(typed)
    while left or right:
        from_chip = bool(left) and (not right or order.random() < 0.5)  # type: ignore[attr-defined]
        mixed.append((left if from_chip else right).pop(0))
    echo.sent(typed, 0.0)
    kept = echo.received(bytes(mixed), 0.0)
    assert sorted(kept) == sorted(said)
    if not set(said) & set(typed):
        assert kept == said
    assert echo.missing == 0


def test_a_line_without_echo_is_pointed_out_once() -> None:
    kept, notes = heard(Wire([b"a", b"b"], echoes=False), b"hello\r")
    assert kept == b"ab"
    assert len(notes) == 1
    assert "does not come back" in notes[0]


def test_a_late_echo_is_no_echo() -> None:
    echo = EchoFilter()
    echo.sent(b"x", 0.0)
    assert echo.received(b"x", 0.6) == b"x"
    assert echo.missing == 1


# -- lines that are no text -----------------------------------------------------------------------


def test_garbage_is_pointed_out_once_and_text_is_not() -> None:
    assert heard(Wire([bytes(range(128, 256))] * 3))[1] == [
        "COM: much of what comes is no text; the program may send at another rate (--baud), or the "
        "line is inverted or has no ground"
    ]
    assert heard(Wire([b"\x02\x05\x07 plain DEBUG text, with control codes\r"] * 9))[1] == []


@pytest.mark.parametrize("error", [OSError("gone"), TypeError("closed"), ValueError("no port")])
def test_a_port_that_vanishes_is_a_sentence(error: Exception) -> None:
    class Gone(Wire):
        def read(self, size: int = 1) -> bytes:
            raise error

    with pytest.raises(RigError, match="COM: the port is gone"):
        heard(Gone([]))


# -- in words -------------------------------------------------------------------------------------


def decoded(robot: str, sent: bytes) -> list[str]:
    return [line.text for line in Decoder(load_robot(robot)).lines(sent)]


def test_a_prey_in_words() -> None:
    sent = b":255 FL1966 FR24666 L0 R983 RL24666 RR24666 AL0 AR0 S9 C6\r"
    (text,) = decoded("servobot-prey", sent)
    assert text.startswith("255: front_left 10.0 in, front_right nothing, left no echo, right 5.0")
    assert text.endswith("left and right touched; both_left_open: state 9, BACKUP_RIGHT")
    assert decoded("servobot-prey", sent.replace(b"S9", b"S4"))[0].endswith(
        "near_right: state 4, BACKUP_RIGHT"
    )


def test_the_lamp_in_inches() -> None:
    line = b":0 F1 R1 L1 LL%d LR%d AL1 AR1 S0 C0\r"
    for counts, words in (
        ((170, 64), "lamp left 12.0 in, right 6.0 in"),
        ((3, 9999), "lamp left 2.0 in, right past 96 in"),
        ((117, 0), "lamp left 9.0 in, right dark"),
    ):
        assert words in decoded("servobot-predator", line % counts)[0]


def test_every_fault_has_a_meaning() -> None:
    assert set(FAULTS) == set(Fault)
    for fault in Fault:
        assert decoded("servobot-prey", f">>*{fault}\r".encode())[0].startswith(f"fault {fault}: ")
    assert decoded("servobot-prey", b"*WHAT\r") == ["fault WHAT"]


def test_other_lines_are_themselves() -> None:
    assert decoded("servobot-prey", b"\x00Hello: 3*4\r\n>>\r!Q5A0F2\r:9 F1\r") == [
        *("Hello: 3*4", "answer Q5A0F2", ":9 F1")
    ]
    sent = b">>#1 M servobot-prey 12345678 9abcdef0\r"
    assert decoded("servobot-prey", sent) == ["main controller of servobot-prey, genome 12345678"]
    assert decoded("servobot-predator", sent)[0].endswith("; read as servobot-predator")


@given(st.lists(st.binary(max_size=40), max_size=8))
def test_no_bytes_are_too_much(parts: list[bytes]) -> None:
    decoder = Decoder(load_robot("servobot-predator"))
    for part in parts:
        for line in decoder.lines(part):
            assert line.text.isprintable()
            json.dumps(line.data)


@given(st.text(alphabet=":FRL0123456789 SCAr\r", max_size=60))
def test_half_a_line_of_telemetry_is_none(text: str) -> None:
    whole = ":7 F1 R2 L3 LL4 LR5 AL1 AR0 S6 C7"
    assert parse_telemetry(whole, Role.PREDATOR) is not None
    assert role_in(whole) is Role.PREDATOR
    for end in range(len(whole) - 1):
        assert parse_telemetry(whole[:end], Role.PREDATOR) is None
    assert parse_telemetry(whole.replace("F1", "F65536"), Role.PREDATOR) is None
    assert parse_telemetry(text, Role.PREY) is None


# -- the verb -------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def prey_url() -> "Callable[[], BytePipe]":
    subject = read_subject(FIRMWARE / "prey")

    def pipe() -> BytePipe:
        return BytePipe(robot_bench(subject.robot, subject.images), kind="rfc2217")

    return pipe


def test_listening_to_a_robot_that_walks(
    prey_url: "Callable[[], BytePipe]", tmp_path: Path, capfdbinary: pytest.CaptureFixture[bytes]
) -> None:
    log = tmp_path / "log.bin"
    with prey_url() as pipe:
        words = ["monitor", "--port", pipe.url, "--for", "4s", "--input", "", "--decode", "--reset"]
        assert main(["--json", *words, "--log", str(log)]) == 0
        assert main([*words, "--log", str(log)]) == 3  # and is left as it is
    out, err = capfdbinary.readouterr()
    lines = [json.loads(line) for line in out.decode().splitlines()]
    decisions = [line for line in lines if line["kind"] == "decision"]
    assert decisions
    assert decisions[0]["movement"] == "WAIT"  # it has said that it is a prey, if not by its banner
    assert b"#1 M servobot-prey " in log.read_bytes()
    assert b"--force" in err


def test_an_emulated_robot_in_its_own_time(capfd: pytest.CaptureFixture[str]) -> None:
    words = ["monitor", "--port", f"emu:{FIRMWARE / 'prey'}", "--input", "", "--decode"]
    assert main([*words, "--for", "5s"]) == 0
    out = capfd.readouterr().out
    assert "main controller of servobot-prey" in out
    assert 1 <= out.count("state 0, WAIT") <= 4  # a gait cycle takes a second, and no less


def test_ctrl_c_while_it_is_reset(
    prey_url: "Callable[[], BytePipe]", capsys: pytest.CaptureFixture[str]
) -> None:
    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    with prey_url() as pipe, pytest.MonkeyPatch.context() as patch:
        patch.setattr(port_module, "reset_by_dtr", stop)
        assert main(["monitor", "--port", pipe.url, "--input", "", "--reset"]) == 0
    assert ": 0 bytes in " in capsys.readouterr().err


def test_a_log_that_cannot_be_written(
    prey_url: "Callable[[], BytePipe]", capfd: pytest.CaptureFixture[str]
) -> None:
    """The disk is full; and what else fails meanwhile is no fault of the log."""
    words = ["--input", "", "--reset", "--log", "/dev/full", "--force", "--for", "60s"]
    with prey_url() as pipe:
        assert main(["monitor", "--port", pipe.url, *words]) == 3
    assert "/dev/full: cannot be written (No space left on device)" in capfd.readouterr().err


def test_nobody_there(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log, old = tmp_path / "new.log", tmp_path / "old.log"
    old.write_text("what was there", "utf-8")
    words = ["monitor", "--port", "/dev/no-such-port", "--for", "1s", "--log"]
    assert main([*words, str(log)]) == 7
    assert "cannot be opened" in capsys.readouterr().err
    assert main([*words, str(old), "--force"]) == 7
    assert (log.exists(), old.read_text("utf-8")) == (False, "what was there")
    assert main(["monitor", "--port", "socket://127.0.0.1:1", "--robot", "servobot-prey"]) == 2
