"""A locomotion controller in bench mode: the words of PROTOCOL.md, and what the legs do then."""

from itertools import pairwise

from cgagen.bench_protocol import DUMP_LINE, FRAME_LIMIT_MS, LISTEN_MS, dump_request, parse_dump
from cgagen.robot.gait import frames_of
from cgagen.stamp.image import Image
from hil.legs_line import walk
from hil.legs_trial import SERVOS, STARTS_MS, LegsTrial, standing, wanted_frames
from hil.trial import MS, answered, ignores, want

PROMPT_MS = 2_500
"""The next prompt has come by then, or when the longest movement may be over. Choice."""

LEAVING_FRAMES = 6
"""Until a movement begins behind the bench, at most. Choice: twice those before any."""

EXTRA_FRAMES = 3
"""Before and behind a movement, at most."""


def speaks(trial: LegsTrial, image: Image) -> None:
    """All requests, right and wrong, walked and dumped; then it waits for GO again."""
    answered(trial, "?Hab", "!Hab")
    if trial.has_step:
        want(not trial.holds, "handshake", "holds the step line in bench mode, as if it accepted")
    trial.command(5)  # the lines are not read in here
    for request, command in (("?M0a", 0), ("?M0a", None), ("?M0a", None), ("?M7b", 7)):
        _bench_movement(trial, request, command)
    for request in ("?M8b", "?M/x", "?Zab", "?D/0", "?D0p", "?D10", "?Qab"):
        answered(trial, request, f"!E{request[2:]}")
    _bench_movement(trial, "?M7b", None)
    _bench_dump(trial, image)
    _bench_movement(trial, "?M7b", None)
    answered(trial, "?Hcd", "!Hcd")
    _bench_movement(trial, "?M7b", 7)
    _centre(trial)
    _bench_movement(trial, "?M7b", None)
    began_ns = trial.now_ns
    trial.go_on(100)
    want(set(trial.frames(began_ns, "gait")) == {trial.rest}, "bench", "does not centre")
    ignores(trial, "!C77")
    _bench_movement(trial, "?M7d", 7)
    (_leave_line if trial.has_step else _leave_three_lines)(trial)


def _leave_line(trial: LegsTrial) -> None:
    """Behind the bench it waits for GO again."""
    want(not trial.holds, "handshake", "holds the step line in bench mode, as if it accepted")
    began_ns = trial.now_ns
    answered(trial, "?Xzz", "!Xzz")
    want(trial.step.level == 1 or trial.wait("step 1", 100), "handshake", "keeps it after leaving")
    trial.go_on(100)
    want(set(trial.frames(began_ns, "gait")) == {trial.rest}, "bench", "moves as it is left")
    trial.command(2)
    trial.wait("pulse 6", 60)
    walk(trial, 2)


def _leave_three_lines(trial: LegsTrial) -> None:
    """Behind the bench it walks what the lines say."""
    trial.command(2)
    began_ns = trial.now_ns
    answered(trial, "?Xzz", "!Xzz")
    want(trial.wait("moved", LEAVING_FRAMES * FRAME_LIMIT_MS), "bench", "stands after leaving")
    want(set(trial.frames(began_ns, "gait")) == {trial.rest}, "bench", "moves as it is left")
    frames, began_ns = wanted_frames(trial.robot, 2, trial.rest), trial.rises[0][-1]
    trial.go_on((len(frames) + 1) * FRAME_LIMIT_MS)
    seen = trial.frames(began_ns, "gait")
    want(seen[: len(frames)] == frames, "gait", "walks another movement after leaving")


def late_hello(trial: LegsTrial) -> None:
    """A hello is heard in every slice of the listening, the last that there has to be, too."""
    began_ns = None
    while began_ns is None or trial.now_ns - began_ns < (LISTEN_MS - 40) * MS:
        want(trial.wait("byte 62", STARTS_MS), "bench", "no prompt")
        began_ns = began_ns or trial.now_ns
    answered(trial, "?Hzz", "!Hzz")


def _bench_movement(trial: LegsTrial, request: str, command: int | None) -> None:
    answered(trial, request, f"!{request[1:]}")
    began_ns = trial.now_ns
    longest = max(frames_of(trial.robot, step) for step in trial.robot.steps)
    limit_ms = max(PROMPT_MS, (longest + EXTRA_FRAMES) * FRAME_LIMIT_MS)
    want(trial.wait("byte 62", limit_ms), "bench", f"no prompt behind {request}")
    seen = trial.frames(began_ns, "bench")
    if command is None:
        want(set(seen) <= {trial.rest}, "bench", f"{request} is walked twice")
        return
    frames = wanted_frames(trial.robot, command, trial.rest)
    extra = len(seen) - len(frames)
    want(1 <= extra <= EXTRA_FRAMES, "bench", f"{request}: {len(seen)} frames")
    at = 1
    want(seen[:at] == [trial.rest], "bench", f"{request}: the first frame")
    trial.rest = frames[-1]
    want(seen[at:] == [*frames, *[trial.rest] * (extra - at)], "bench", f"{request}: pulses")


def _centre(trial: LegsTrial) -> None:
    """One leg after another goes to the centre, each with frames of its own."""
    answered(trial, "?C99", "!C99")
    began_ns = trial.now_ns
    want(trial.wait("byte 62", PROMPT_MS), "bench", "no prompt behind ?C99")
    seen = [trial.rest, *trial.frames(began_ns, "bench")]
    moved = [frame for frame, before in zip(seen[1:], seen, strict=False) if frame != before]
    want(len(moved) == SERVOS // 2, "bench", f"centres in {len(moved)} parts")
    since = 0
    for before, frame in pairwise(seen):
        since += 1
        legs = {n // 2 for n in range(SERVOS) if before[n] != frame[n]}
        want(len(legs) <= 1, "bench", f"centres {len(legs)} legs at once")
        if legs:
            least = trial.robot.servo_set.start_frames
            want(since == least or frame == moved[0], "bench", f"centres a leg in {since} frames")
            since = 0
    trial.rest = standing(trial.robot)
    want(seen[-1] == trial.rest, "bench", "does not centre")


def _bench_dump(trial: LegsTrial, image: Image) -> None:
    for first, last in ((0, 63), (2016, 2047)):
        request = dump_request(first, last)
        said = trial.ask(request, limit_ms=3_000)
        lines = [parse_dump(line) for line in said.split("\r")]
        found = [line for line in lines if line]
        want([line[0] for line in found] == list(range(first, last, 16)), "dump", "addresses")
        want(said.count(DUMP_LINE) == len(found), "dump", "a line that is none")
        data = b"".join(line[1] for line in found)
        want(data == image.eeprom[first : last + 1], "dump", "bytes")
        want(said.endswith(f"\r!{request[1:]}\r"), "dump", "no end")
