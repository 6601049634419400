"""A main controller in bench mode: the words of PROTOCOL.md, and what follows from each."""

from cgagen.bench_protocol import (
    DUMP_LINE,
    END,
    LISTEN_MS,
    MAIN_SLICE_MS,
    READING_MS,
    dump_request,
    parse_dump,
    reading_text,
)
from cgagen.errors import LackingError
from cgagen.stamp.image import Image
from hil.main_trial import MainTrial, levels
from hil.main_wanted import Wanted
from hil.simulated import commands_by_state
from hil.target import Observation, Stimulus
from hil.trial import FIRST_PROMPT_MS, MS, answered, ignores, want

SOON_MS = 380
"""What a look at all sensors, a decision and GO take, without the gaps between sonars. Choice."""


def speaks(trial: MainTrial, wanted: Wanted, image: Image) -> None:
    """All requests, right and wrong; then it hunts again."""
    answered(trial, "?Hab", "!Hab")
    ignores(trial, "!H77")
    for number, (stimulus, right) in enumerate(wanted.hunts):
        _question(trial, f"?Q{number:x}x", stimulus, right)
    _bad_readings(trial, wanted.hunts[0][0])
    for request in ("?Zab", "?D/0", "?D0p", "?D10", "?Mab"):
        answered(trial, request, f"!E{request[2:]}")
    answered(trial, "?Hcd", "!Hcd")
    _dump(trial, image)
    _table(trial)
    lines = trial.line_bits | trial.step_bit
    want(not trial.drives & lines, "bench", "drives a line in bench mode")
    stimulus, right = wanted.hunts[1]
    trial.present(stimulus)
    _all_bits(trial, stimulus)
    answered(trial, "?Xzz", "!Xzz")
    trial.forget()
    want(trial.wait("look", 20), "bench", "does not hunt after leaving")
    want(not trial.said, "bench", f"says {trial.said!r} after leaving")
    soon_ms = SOON_MS + len(stimulus.sonars) * trial.robot.echo.trigger_gap_ms
    want(trial.wait_decided(soon_ms), "bench", "does not tell its decision soon after leaving")
    want(trial.lines() == right.command, "bench", f"says {trial.lines()} after leaving")


def _all_bits(trial: MainTrial, stimulus: Stimulus) -> None:
    """Leave bits that sensing does not write in the word of the antennas, and a right sum."""
    counts = (*stimulus.sonars, *stimulus.lights)
    words = reading_text(3, counts).rstrip(END).split(" ")
    words[:2] = "F", f"{counts[0] - (0xF - 3):04X}"
    said = trial.ask("?Qff", " ".join(words) + END)
    want("!Qff" in said, "bench", f"an antennas' word of four bits is answered {said!r}")


def late_hello(trial: MainTrial) -> None:
    """A hello in the last slice is heard, too."""
    for _ in range(LISTEN_MS // MAIN_SLICE_MS - 1):
        want(trial.wait("byte 62", FIRST_PROMPT_MS), "bench", "no prompt")
    answered(trial, "?Hzz", "!Hzz")


def _question(trial: MainTrial, request: str, stimulus: Stimulus, right: Observation) -> None:
    reading = reading_text(levels(stimulus), (*stimulus.sonars, *stimulus.lights))
    said = trial.ask(request, reading)
    answer = f"!{request[1:]}{right.state:02X}{right.command:X}\r"
    want(said == f"{request}>{reading}{answer}", "bench", f"{request} is answered {said!r}")


def _bad_readings(trial: MainTrial, stimulus: Stimulus) -> None:
    """A number that changed on its way is refused, whichever it is; so is silence."""
    counts = (*stimulus.sonars, *stimulus.lights)
    words = reading_text(3, counts).rstrip(END).split(" ")
    for at in range(len(words)):
        bad = words.copy()
        bad[at] = f"{int(bad[at], 16) ^ 1:0{len(bad[at])}X}"
        reading = " ".join(bad) + END
        said = trial.ask("?Qsx", reading)
        want(said == f"?Qsx>{reading}!Esx\r", "bench", f"bad number {at} is answered {said!r}")
    want(trial.wait("byte 62", 100), "bench", "no prompt")
    trial.go_on(2)
    trial.forget()
    trial.host.send(b"?Qnn")
    want(trial.wait("byte 62", 100), "bench", "no prompt for readings")
    began_ns = trial.now_ns
    want(trial.wait("byte 33", READING_MS + 10), "bench", "waits too long for readings")
    want(trial.now_ns - began_ns >= READING_MS * MS, "bench", "does not wait for readings")
    want(trial.wait("byte 13", 50) and trial.said == "?Qnn>!Enn\r", "bench", "no refusal")


def _dumped(trial: MainTrial, first: int, last: int) -> bytes:
    request = dump_request(first, last)
    said = trial.ask(request, limit_ms=2_000)
    found = [line for line in map(parse_dump, said.split("\r")) if line]
    want([line[0] for line in found] == list(range(first, last, 16)), "dump", "addresses")
    want(said.count(DUMP_LINE) == len(found), "dump", "a line that is none")
    want(said.endswith(f"\r!{request[1:]}\r"), "dump", "no end")
    return b"".join(line[1] for line in found)


def _dump(trial: MainTrial, image: Image) -> None:
    for first, last in ((0, 63), (2016, 2047)):
        data = _dumped(trial, first, last)
        want(data == image.eeprom[first : last + 1], "dump", "bytes")


def _table(trial: MainTrial) -> None:
    """The whole table is what was evolved, also where no reading leads."""
    commands = bytes(commands_by_state(trial.subject))
    at = trial.image.eeprom.find(commands)
    if at < 0:
        trial.lacks.append(LackingError("its commands lie nowhere in one piece, to be read back"))
        return
    data = _dumped(trial, at // 32 * 32, (at + len(commands) - 1) // 32 * 32 + 31)
    want(commands in data, "table", "is another one")
