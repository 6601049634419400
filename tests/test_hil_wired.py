"""The bench hook on a wire: real drivers against the emulated robot behind a socket or a pty."""

import socket

import pytest

from cgagen.emulator.bench import Bench
from cgagen.errors import IdentityError, RigError, TargetTimeout
from cgagen.flash import plan_of
from cgagen.link import bench_hook, prompted
from cgagen.link.bench_hook import BenchHook
from cgagen.link.lock import PortLock
from cgagen.stamp.image import Image
from cgagen.stamp.packets import BLOCK_BYTES
from hil.emulated import robot_bench
from hil.equivalence import Verdict, compare
from hil.pipe import BytePipe
from hil.registers import calibration
from hil.stimuli import every_state, neutral, thresholds
from hil.subject import Subject
from hil.target import Stimulus
from hil.targets import make_target
from hil.verify import try_target
from hil.wired import WiredTarget
from hil.wired_walks import try_legs
from tests.subjects import subject


def bench(one: Subject) -> Bench:
    return robot_bench(one.robot, one.images)


class Repeating(BytePipe):
    """Says the answer before once more, in front of each answer to a question."""

    old = b""
    line = bytearray()

    def outgoing(self, data: bytes) -> bytes:
        out = bytearray()
        for byte in data:
            if byte == ord("!") and self.old:
                out += self.old
            self.line.append(byte)
            out.append(byte)
            if byte == ord("\r"):
                at = self.line.rfind(b"!Q")
                self.old = bytes(self.line[at:]) if at >= 0 else self.old
                self.line.clear()
        return bytes(out)


class Dying(BytePipe):
    """Falls silent when it is asked a question."""

    silent, before = False, b""

    def outgoing(self, data: bytes) -> bytes:
        heard, self.before = self.before + data, data[-1:]  # a block of a dump may be called Q
        self.silent = self.silent or b"?Q" in heard or b"!Q" in heard
        return b"" if self.silent else data


class Mute(BytePipe):
    """Loses what an answer to a question begins with."""

    def outgoing(self, data: bytes) -> bytes:
        return data.replace(b"Q", b"")


class Swallowing(BytePipe):
    """Loses the answer to a request to leave, as often as is wanted."""

    left = 1

    def outgoing(self, data: bytes) -> bytes:
        if self.left and b"!X" in data:
            self.left -= 1
            return data.replace(b"!X", b"")
        return data


@pytest.mark.parametrize(("role", "kind"), [("predator", "socket"), ("prey", "pty")])
def test_the_bench_hook_decides_as_the_simulator_does(role: str, kind: str) -> None:
    one = subject(role)
    readings = [*list(every_state(one.robot).values())[::3], *list(thresholds(one.robot))[::9]]
    with BytePipe(bench(one), kind=kind) as pipe:
        target = WiredTarget(pipe.url, one, gaps=False)
        target.open()
        trial = compare(one, target, [calibration(one.robot), *readings])
        target.close()
    assert (trial.verdict, trial.reason, trial.stale) == (Verdict.PASS, "", 0)
    assert trial.decisions == len(readings) + 1
    assert pipe.failure is None


def test_stale_answers_on_the_wire_are_discarded_and_counted() -> None:
    one = subject("predator")
    readings = list(every_state(one.robot).values())[:5]
    with Repeating(bench(one)) as pipe:
        trial = try_target(one, lambda: WiredTarget(pipe.url, one, gaps=False), readings)
    assert (trial.verdict, trial.decisions) == (Verdict.PASS, 5)
    assert trial.stale == 4


@pytest.mark.parametrize("kind", [BytePipe, Swallowing])
def test_a_robot_that_is_left_hunts_again(
    kind: type[BytePipe], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its answer may be lost: it has left if it does not listen any more."""
    one = subject("prey")
    with kind(bench(one)) as pipe:
        hook = BenchHook(pipe.url, gaps=False)
        with hook:
            hook.hello()
            hook.leave()
            monkeypatch.setattr(bench_hook, "HELLO_S", 0.5)
            with pytest.raises(RigError, match="no prompt came"):
                hook.hello()
        assert hook.unheard == (kind is Swallowing)
    assert pipe.failure is None


def test_a_chip_with_other_bytes_is_blocked(monkeypatch: pytest.MonkeyPatch) -> None:
    one = subject("predator")
    image = one.images["main"]
    eeprom = bytearray(image.eeprom)
    eeprom[bytes(eeprom).index(bytes(one.genome.commands())) + 5] ^= 1  # type: ignore[union-attr]
    wrong = Image(image.model, bytes(eeprom))
    with BytePipe(robot_bench(one.robot, {**one.images, "main": wrong})) as pipe:
        trial = try_target(one, lambda: WiredTarget(pipe.url, one, gaps=False), [])
        assert trial.verdict is Verdict.BLOCKED
        assert "EEPROM has digest" in trial.reason
        prey = subject("prey")
        with pytest.raises(IdentityError, match="not servobot-prey"):
            WiredTarget(pipe.url, prey, gaps=False).open()


def test_a_chip_with_a_past_is_no_other_chip() -> None:
    """A download leaves the blocks that it does not send as they were."""
    one = subject("predator")
    image = one.images["main"]
    past = bytearray(b"\xa5" * len(image.eeprom))
    for block in plan_of(image).blocks:
        span = slice(block * BLOCK_BYTES, (block + 1) * BLOCK_BYTES)
        past[span] = image.eeprom[span]
    assert bytes(past) != image.eeprom
    used = Image(image.model, bytes(past))
    with BytePipe(robot_bench(one.robot, {**one.images, "main": used})) as pipe:
        with WiredTarget(pipe.url, one, gaps=False) as target:
            assert target.identity().images == {"main": image.digest}


def test_a_chip_that_falls_silent_is_blocked(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bench_hook, "ANSWER_S", 0.3)
    monkeypatch.setattr(prompted, "LIFE_S", 0.1)
    one = subject("prey")
    with Dying(bench(one)) as pipe:
        trial = try_target(
            one, lambda: WiredTarget(pipe.url, one, gaps=False), [neutral(one.robot)]
        )
    assert trial.verdict is Verdict.BLOCKED
    assert "nothing else comes either" in trial.reason


def test_a_port_where_nobody_answers_is_blocked(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bench_hook, "HELLO_S", 0.2)
    one = subject("predator")
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = f"socket://127.0.0.1:{server.getsockname()[1]}"
        with pytest.raises(RigError, match="no prompt came, and nothing else"):
            WiredTarget(port, one).open()
    with pytest.raises(RigError, match="cannot be opened"):
        WiredTarget("/dev/no-such-port", one).open()


def test_a_port_has_one_session_at_a_time() -> None:
    one = subject("predator")
    first = PortLock("/dev/port-of-a-test")
    first.take()
    second = WiredTarget("/dev/port-of-a-test", one)
    with pytest.raises(RigError, match="another session"):
        second.open()
    first.release()
    with pytest.raises(RigError, match="cannot be opened"):
        second.open()


class Unheard(BenchHook):
    """Says what it has to say to nobody."""

    def speak(self, request: str, deadline_s: float) -> None:
        raise RigError(request)


def test_sessions_begin_with_numbers_of_their_own() -> None:
    """So a stale answer to the host before is none to this one."""
    first = set()
    for _ in range(50):
        hook = Unheard("/dev/none")
        with pytest.raises(RigError):
            hook.hello()
        first.add(hook.nonce)
    assert "" not in first
    assert len(first) > 1


def test_a_chip_that_lives_and_does_not_answer_has_failed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bench_hook, "ANSWER_S", 1.0)
    one = subject("predator")
    with Mute(bench(one)) as pipe:
        trial = try_target(
            one, lambda: WiredTarget(pipe.url, one, gaps=False), [calibration(one.robot)]
        )
    assert trial.verdict is Verdict.FAIL
    assert "though the chip is alive" in trial.reason


def test_readings_that_are_always_refused_are_a_sick_bench(monkeypatch: pytest.MonkeyPatch) -> None:
    """Readings of more sonars than the chip has: each sum is wrong, as on a bad cable."""
    monkeypatch.setattr("hil.wired.check_reading", lambda *_: None)
    monkeypatch.setattr(bench_hook, "ANSWER_S", 1.0)
    one = subject("predator")
    with BytePipe(bench(one)) as pipe:
        target = WiredTarget(pipe.url, one, gaps=False)
        target.open()
        with pytest.raises(RigError, match=r"refuses the readings .* spoiled") as raised:
            target.decide(Stimulus((1, 2, 3, 4), lights=(0, 0)))
        assert not isinstance(raised.value, TargetTimeout)
        monkeypatch.undo()
        trial = compare(one, target, [calibration(one.robot)])
        target.close()
    assert trial.verdict is Verdict.PASS


class Remembering(BytePipe):
    """Gives the host before the first answer to hello, as an adapter that kept it would."""

    hellos = 0

    def outgoing(self, data: bytes) -> bytes:
        self.hellos += data.count(b"!H")
        return data.replace(b"!H", b"!H~~\r=", 1) if self.hellos == 1 else data


def test_the_answer_to_another_hello_is_none() -> None:
    one = subject("prey")
    with Remembering(bench(one)) as pipe, BenchHook(pipe.url, gaps=False) as hook:
        assert hook.hello() == hook.nonce
        assert pipe.hellos == 2


class Slow(BytePipe):
    """An adapter that swallows all but the banner for a while: until the reset behind that."""

    resets = 0

    def outgoing(self, data: bytes) -> bytes:
        self.resets += data.count(b"#")
        return data if self.resets > 1 else data.replace(b">", b"")


def test_a_host_that_missed_the_half_second_resets_again(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bench_hook, "HASTE_S", 0.3)
    one = subject("prey")
    with Slow(bench(one), "locomotion", "rfc2217") as pipe, BenchHook(pipe.url, False) as hook:
        assert hook.enter().chip == "locomotion"
        assert pipe.resets == 2
        hook.centre()


def test_a_robot_at_work_is_reset_where_that_is_asked_for() -> None:
    """Otherwise it is left alone, and the bench is sick, not the firmware."""
    one = subject("prey")
    with BytePipe(bench(one), "main", "rfc2217") as pipe:
        name = f"serial-reset:{pipe.url}"
        first = make_target(name, one)
        first.open()
        first.close()
        with BenchHook(pipe.url) as hook:
            hook.hello()
            hook.leave()
        trial = try_target(one, lambda: make_target(f"serial:{pipe.url}", one), [])
        assert trial.verdict is Verdict.BLOCKED
        assert trial.reason.endswith(f"or have it reset by DTR: {name}")
        target = make_target(name, one)
        target.open()
        assert target.identity().robot == one.robot.name
        target.close()


def test_the_legs_take_every_command() -> None:
    one = subject("predator")
    robot = bench(one)
    with BytePipe(robot, "locomotion", "rfc2217") as pipe:
        trial = try_legs(f"serial-reset:{pipe.url}", one)
        assert (trial.verdict, trial.reason) == (Verdict.PASS, "")
        assert trial.tried == trial.agreed == dict.fromkeys(range(8), 1)
        other = try_legs(f"serial-reset:{pipe.url}", subject("prey"))
        assert other.verdict is Verdict.BLOCKED
        assert "the chip holds servobot-predator" in other.reason
        assert other.agreed == {}
    with pytest.raises(RigError, match="can:0: no such port of legs"):
        try_legs("can:0", one)


def test_legs_that_never_come_to_rest(monkeypatch: pytest.MonkeyPatch) -> None:
    """What was walked before counts; the chip lives, so the firmware has failed."""
    monkeypatch.setattr(bench_hook, "WALK_S", 0.0)
    one = subject("prey")
    with BytePipe(bench(one), "locomotion", "rfc2217") as pipe:
        trial = try_legs(f"serial-reset:{pipe.url}", one)
    assert trial.verdict is Verdict.FAIL
    assert "movement 0 is not over" in trial.reason
    assert (trial.tried, trial.agreed) == ({0: 1}, {})
