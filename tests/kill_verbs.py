"""Do verbs that are stopped or killed at any moment leave anything half done behind?

    python -m tests.kill_verbs --count 300 --seed 1

Each verb runs once undisturbed. Then one after the other is begun in a folder of its own and sent
SIGINT, SIGTERM or SIGKILL, by turns after a random time and at a random moment while something is
being written, and this has to hold:

* its exit code is that of the signal (a run that was stopped: 10), or 0 where it was done before;
* there is no traceback, and no process of it is left;
* what bears the name of an output is whole: the undisturbed one's bytes, or its beginning in lines
  where Ctrl-C counts as an end (a waveform);
* behind SIGINT and SIGTERM there is no temporary of ours; behind SIGKILL the next run sweeps it;
* the same verb again, or `resume`, comes to the same bytes as if nothing had happened.
"""

import argparse
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import click

from cgagen.temporaries import is_temporary
from cgagen.toolchain import find_tokenizer

ROOT = Path(__file__).parent.parent
GENOME = ROOT / "firmware" / "reference.genome"
PREY = ROOT / "firmware" / "prey"
PROGRAM = ROOT / "tests" / "programs" / "fibonacci.bs2"
MARKS = "sensor,distance_in,count\nfront,24,4425\nfront,24,4430\nfront,12,2210\n"
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGKILL)
LIMIT_S = 300
WRITING_S = 0.2
"""How long behind the first temporary a late kill comes at most. Choice: most are gone by then."""

ORPHAN_S = 15.0
"""How long a worker may take to see that its owner is gone, on a busy machine. Choice."""

BEFORE = b"Fatal Python error: init_import_site"
"""What the interpreter says where Ctrl-C comes before it has come to any code of ours."""

EVOLVE = "evolve --generations 30 --population 64 --starts 2 --steps 60 --fixed-starts 8"


@dataclass(frozen=True)
class Verb:
    """One verb that is to be killed.

    Attributes:
        name: what it is called here.
        words: after `cgagen`; {genome} and the like are put in.
        again: what is called afterwards; "" for the same. With a run: where there is one to go on.
        code: the exit code of one that was stopped; None for the signal's own.
        lines: outputs of which the first lines may be there.
        prepared: the folder is one in which this verb has been to its end already.
        slow: left out of small samples.
    """

    name: str
    words: str
    again: str = ""
    code: int | None = None
    lines: frozenset[str] = frozenset()
    prepared: bool = False
    slow: bool = False


VERBS = (
    Verb("compile", "compile {program} -o it.bin --map it.map"),
    Verb("build", "build {genome} -o b"),
    Verb("build again", "build {genome} -o b", prepared=True),
    Verb(
        "emulate",
        "emulate {prey}/bench.toml --for 2s --vcd it.vcd --trace it.csv --coverage it.info",
        lines=frozenset({"it.vcd", "it.csv"}),
    ),
    Verb("record", "trace record {genome} -o t.log --sweep"),
    Verb("convert", "trace convert {trace} t.csv"),
    Verb("setup", "setup --offline {tokenizer}"),
    Verb("calibrate", "calibrate marks.csv --robot servobot-predator -o mine.toml --force"),
    Verb("evolve", f"{EVOLVE} --run r --workers 1", "resume r", code=10, slow=True),
    Verb("trials", f"{EVOLVE} --run r --trials 2 --workers 2", "resume r", code=10, slow=True),
    Verb(
        "verify", "verify --build {prey} --level smoke --report v.html --report v.json", slow=True
    ),
)


@dataclass
class Bench:
    """Where verbs are killed.

    Attributes:
        folder: of all of it.
        whole: the files of an undisturbed run, by verb and name.
        took_s: how long that took.
    """

    folder: Path
    whole: dict[str, dict[str, bytes]] = field(default_factory=dict)
    took_s: dict[str, float] = field(default_factory=dict)

    def call(self, words: str, place: Path, cache: Path) -> "subprocess.Popen[bytes]":
        """Begin a verb in a folder."""
        said = words.format(
            genome=GENOME,
            program=PROGRAM,
            prey=PREY,
            tokenizer=find_tokenizer(),
            trace=ROOT / "hil" / "traces" / "sweep.log",
        )
        environment = {
            **{name: value for name, value in os.environ.items() if name != "CGAGEN_TOKENIZER"},
            "XDG_CACHE_HOME": str(cache),
            "TMPDIR": str(place / "tmp"),
            "HOME": str(place),
        }
        if not said.startswith("setup"):
            environment["CGAGEN_TOKENIZER"] = str(find_tokenizer())
        return subprocess.Popen(
            [sys.executable, "-m", "cgagen", "--no-progress", *said.split()],
            cwd=place,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            start_new_session=True,
        )

    def cache_of(self, verb: Verb, place: Path) -> Path:
        """Return the verb's cache: its own where it fills one, else the one that is warm."""
        return place / "cache" if verb.name == "setup" else self.folder / "cache"

    def place(self, verb: Verb, name: str, fresh: bool = False) -> Path:
        """Make a folder for one call."""
        place = self.folder / name
        if verb.prepared and not fresh:
            shutil.copytree(self.folder / f"whole {verb.name}", place)
        else:
            (place / "tmp").mkdir(parents=True)
            (place / "marks.csv").write_text(MARKS)
        return place

    def undisturbed(self, verb: Verb) -> None:
        """Run a verb to its end, twice: the first time fills the cache."""
        for _ in range(2):
            place = self.folder / f"whole {verb.name}"
            shutil.rmtree(place, ignore_errors=True)
            self.place(verb, place.name, fresh=True)
            began_s = time.monotonic()
            with self.call(verb.words, place, self.cache_of(verb, place)) as process:
                err = process.communicate(timeout=LIMIT_S)[1]
            if process.returncode:
                raise SystemExit(f"{verb.name} does not work: {err.decode()}")
            self.took_s[verb.name] = time.monotonic() - began_s
            self.whole[verb.name] = contents(place)

    def kill(self, verb: Verb, number: int, share: float, late: bool, name: str) -> Iterator[str]:
        """Kill a verb once, begin it again; gives what was wrong.

        Args:
            verb: which.
            number: of the signal.
            share: when, of the time that it takes undisturbed.
            late: not before it has begun to write.
            name: of the folder.
        """
        place = self.place(verb, name)
        cache = self.cache_of(verb, place)
        whole = self.whole[verb.name]
        with self.call(verb.words, place, cache) as process:
            if late:
                wait_for_writing(process, place)
            try:
                wait_s = share * (WRITING_S if late else self.took_s[verb.name])
                err = process.communicate(timeout=wait_s)[1]
            except subprocess.TimeoutExpired:
                process.send_signal(number)
                err = process.communicate(timeout=LIMIT_S)[1]
        code = process.returncode
        if BEFORE in err:  # nothing of ours has run
            code, err = -number, b""
        stopped = {-number, 128 + number if verb.code is None else verb.code}
        if number != signal.SIGKILL:
            stopped |= {128 + number}
        if code not in {0, *stopped}:
            yield f"exit code {code}: {err.decode()[-600:]}"
        if b"Traceback" in err and code != -number:
            yield f"a traceback: {err.decode()[-600:]}"
        left = orphans(process.pid)
        if left:
            yield f"processes are left: {left}"
        if number != signal.SIGKILL and temporaries(place):
            yield f"temporaries are left (exit code {code}): {temporaries(place)}"
        found = contents(place)
        if code == 0 and found != whole:
            yield f"done, and other files: {differences(found, whole)}"
        if verb.code is None:
            yield from (
                f"{one} is not whole"
                for one, data in found.items()
                if not is_temporary_path(one) and not is_whole(verb, one, data, whole)
            )
        yield from self._again(verb, place, cache)
        shutil.rmtree(place)

    def _again(self, verb: Verb, place: Path, cache: Path) -> Iterator[str]:
        """Begin a verb again, or go on with its run, and compare what comes of it."""
        has_run = (place / "r" / "0-run.toml").exists()
        words = verb.again if verb.again and has_run else verb.words
        with self.call(words, place, cache) as process:
            err = process.communicate(timeout=LIMIT_S)[1]
        if process.returncode:
            yield f"again: exit code {process.returncode}: {err.decode()[-600:]}"
        if temporaries(place):
            yield f"again: temporaries are left: {temporaries(place)}"
        found = contents(place)
        if found != self.whole[verb.name]:
            yield f"again: other files: {differences(found, self.whole[verb.name])}"


def wait_for_writing(process: "subprocess.Popen[bytes]", place: Path) -> None:
    """Wait until there is a temporary, or the process has ended."""
    folders = [place, place / "r", place / "cache" / "cgagen", place / "tmp"]
    while process.poll() is None:
        for folder in folders:
            if folder.is_dir() and any(map(is_temporary, os.listdir(folder))):
                return
        time.sleep(0.0005)


def contents(folder: Path) -> dict[str, bytes]:
    """Return all files of a folder but the caches of Python's and Numba's."""
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.name != ".lock"
    }


def temporaries(folder: Path) -> list[str]:
    """Return the temporaries of ours under a folder."""
    found = [path.relative_to(folder) for path in folder.rglob("*") if is_temporary(path.name)]
    return sorted(map(str, found))


def is_temporary_path(name: str) -> bool:
    """Whether a file is a temporary, or in one."""
    return any(is_temporary(part) for part in Path(name).parts)


def is_whole(verb: Verb, name: str, data: bytes, whole: dict[str, bytes]) -> bool:
    """Whether a file is what it should be, or as much of it as is allowed."""
    wanted = whole.get(name)
    if wanted is None:
        return False
    if name in verb.lines:
        return data.endswith(b"\n") and (wanted.startswith(data[:-1].rpartition(b"#")[0]))
    # Counts of a run that was stopped are smaller; they have their form and their end.
    if name.startswith("it.info"):
        return data.endswith(b"\n") and data[:8] == wanted[:8]
    return data == wanted


def differences(found: dict[str, bytes], wanted: dict[str, bytes]) -> list[str]:
    """Return the names of files that differ."""
    return [name for name in sorted({*found, *wanted}) if found.get(name) != wanted.get(name)]


def orphans(session: int) -> list[int]:
    """Return what still runs of a session, once it has had time to end."""
    until_s = time.monotonic() + ORPHAN_S
    while left := list(_running(session)):
        if time.monotonic() > until_s:
            return left
        time.sleep(0.05)
    return []


def _running(session: int) -> Iterator[int]:
    for entry in Path("/proc").iterdir():
        if not entry.name.isdecimal():
            continue
        try:
            fields = (entry / "stat").read_text("utf-8", "replace").rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[3]) == session and fields[0] != "Z":
            yield int(entry.name)


def kills(count: int, seed: int, verbs: tuple[Verb, ...] = VERBS) -> tuple[Counter[str], list[str]]:
    """Kill verbs so many times; returns how often each, and what was wrong."""
    chance, done, wrong = random.Random(seed), Counter[str](), list[str]()
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(Path(folder))
        for verb in verbs:
            bench.undisturbed(verb)
        for number in range(count):
            verb = verbs[number % len(verbs)]
            sent = chance.choice(SIGNALS)
            # Imports take most of a call, and writing little of it.
            late = chance.random() < 0.6
            share = chance.uniform(0.0, 1.0) ** 2 if late else chance.uniform(0.0, 1.1)
            done[f"{verb.name} {sent.name}"] += 1
            when = f"{share:.3f}{' of its writing' if late else ''}"
            for what in bench.kill(verb, sent, share, late, f"kill {number}"):
                wrong.append(f"{number}: {verb.name}, {sent.name} at {when}: {what}")
                click.echo(wrong[-1])
    return done, wrong


def main() -> int:
    """Kill, and print the counts."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--verb", action="append", help="These alone.")
    given = parser.parse_args()
    verbs = tuple(verb for verb in VERBS if given.verb is None or verb.name in given.verb)
    began_s = time.monotonic()
    done, wrong = kills(given.count, given.seed, verbs)
    for name, count in sorted(done.items()):
        click.echo(f"{name:<24}{count:>5}")
    sick = len({one.partition(":")[0] for one in wrong})
    took_s = time.monotonic() - began_s
    click.echo(f"{given.count - sick} of {given.count} kills left nothing wrong; {took_s:.0f} s")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
