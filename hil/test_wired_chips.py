"""Both controllers on a wire: real drivers against the emulated robot, its servos watched."""

from pathlib import Path

import pytest

from cgagen.emulator.bench import Bench
from cgagen.errors import IdentityError, RigError
from hil.emulated import robot_bench
from hil.gait_reader import Frame, GaitReader
from hil.pipe import BytePipe
from hil.simulated import SimulatedTarget
from hil.stimuli import every_state
from hil.subject import Subject, read_subject
from hil.wired import WiredLegs, WiredTarget

pytestmark = pytest.mark.hil_req("BENCH")

FIRMWARE = Path(__file__).parent.parent / "firmware"
ORDERS = {"predator": (3, 0, 7, 1, 2, 6, 4, 5), "prey": (1, 7)}
"""Movements, each behind another one: all of a predator's, and a prey's that it has not."""

FOREVER_NS = 1 << 60
MS = 1_000_000


def subject(role: str) -> Subject:
    return read_subject(FIRMWARE / role)


def bench_of(one: Subject, chip: str = "locomotion") -> Bench:
    """A robot whose other controller stays in reset."""
    bench = robot_bench(one.robot, one.images)
    bench.reset("main" if chip == "locomotion" else "locomotion", FOREVER_NS)
    return bench


def alike(frame: Frame, other: Frame) -> bool:
    return all(abs(a - b) <= 4_000 for a, b in zip(frame, other, strict=True))


@pytest.mark.parametrize(("role", "kind"), [("predator", "socket"), ("prey", "pty")])
def test_a_locomotion_controller_walks_on_a_wire(role: str, kind: str) -> None:
    """Movements are read from the pulses of twelve servos; a repeated sign is walked once."""
    one, order = subject(role), ORDERS[role]
    bench = bench_of(one)
    gait = GaitReader(one.robot, bench)
    standing, times_ns = gait.rest, [0]
    with BytePipe(bench, "locomotion", kind) as pipe:
        with WiredLegs(pipe.url, one, gaps=False) as legs:
            times_ns.append(bench.clock.now_ns)
            for command, sign in [*((one, None) for one in order), (6, "~"), (6, "~")]:
                legs.move(command, sign)
                times_ns.append(bench.clock.now_ns)
            legs.centre()
            times_ns.append(bench.clock.now_ns)
            let_go = bench.wire("step").level
            legs.leave()
        assert pipe.failure is None
    bench.run(bench.clock.now_ns + 100 * MS)
    assert (let_go, bench.wire("step").level) == (1, 1)  # held, it would look accepted
    talk, *walks, again, centred, _ = gait.take().cut(times_ns)
    assert gait.rested(talk) == ""
    assert [gait.find(walk).command for walk in walks] == [*order, 6]
    assert gait.rested(again) == ""
    assert not alike(gait.rest, standing), "the legs come from elsewhere"
    assert alike(centred.whole_frames()[-1], standing)


def test_a_reset_of_the_main_controller_is_seen_and_clean() -> None:
    one = subject("prey")
    reading = list(every_state(one.robot).values())[2]
    bench = bench_of(one, "main")
    with BytePipe(bench, "main", "rfc2217") as pipe, WiredTarget(pipe.url, one, False) as target:
        for _ in range(2):
            nonce = target.hook.nonce
            target.reset()
            assert target.hook.greeting is not None
            assert target.hook.greeting.robot == one.plain_name
            assert target.hook.nonce != nonce
            assert target.decide(reading).command == SimulatedTarget(one).decide(reading).command
        assert target.stale == 0
    assert pipe.failure is None


def test_a_reset_of_the_locomotion_controller_centres_and_forgets() -> None:
    """Behind it the legs stand straight, the step line is free, and a sign is new again."""
    one = subject("prey")
    bench = bench_of(one)
    gait = GaitReader(one.robot, bench)
    standing, times_ns = gait.rest, [0]
    with BytePipe(bench, "locomotion", "rfc2217") as pipe, WiredLegs(pipe.url, one, False) as legs:
        legs.move(6, "a")
        times_ns.append(bench.clock.now_ns)
        legs.reset()
        assert bench.wire("step").level == 1
        times_ns.append(bench.clock.now_ns)
        legs.move(6, "a")
    assert pipe.failure is None
    before, centring, walk = (train.whole_frames() for train in gait.take().cut(times_ns))
    assert not alike(before[-1], standing), "a movement ends elsewhere"
    assert alike(centring[-1], standing)
    assert alike(walk[0], standing)
    assert not alike(walk[-1], standing), "it was walked again"


@pytest.mark.parametrize("kind", ["socket", "pty"])
def test_a_port_without_dtr_says_so(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("cgagen.link.bench_hook.HELLO_S", 1.0)
    one = subject("prey")
    with BytePipe(bench_of(one, "main"), "main", kind) as pipe:
        target = WiredTarget(pipe.url, one, gaps=False)
        with target, pytest.raises(RigError, match=r"no DTR|no banner came"):
            target.reset()


def test_the_controllers_are_not_taken_for_each_other() -> None:
    one = subject("prey")
    with (
        BytePipe(bench_of(one, "main"), "main") as pipe,
        pytest.raises(IdentityError, match="the main controller is behind it"),
    ):
        WiredLegs(pipe.url, one, gaps=False).open()


def test_a_request_for_the_other_controller_is_refused() -> None:
    one = subject("prey")
    with BytePipe(bench_of(one, "main"), "main") as pipe:
        target = WiredTarget(pipe.url, one, gaps=False)
        with target, pytest.raises(RigError, match=r"does not take \?M3"):
            target.hook.move(3)


def test_a_reset_into_another_program_is_noticed() -> None:
    """Somebody has loaded another robot's build meanwhile."""
    one, other = subject("prey"), subject("predator")
    bench = robot_bench(one.robot, {**one.images, "main": other.images["main"]})
    with BytePipe(bench, "main", "rfc2217") as pipe:
        target = WiredTarget(pipe.url, one, gaps=False)
        target.hook.open()
        with pytest.raises(IdentityError, match="holds servobot-predator"):
            target.reset()
        target.close()
