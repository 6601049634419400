"""Damaged files for every reader: none ends as a bug of ours, takes long, or takes the memory.

::

    python -m tests.fuzz_inputs --count 20000 --seed 1 [--reader genome --reader bench]

Each reader is the one that the verbs use, and what it raises ends as `cgagen.cli.main` ends it.
"""

import argparse
import contextlib
import io
import random
import resource
import sys
import tempfile
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from cgagen.verbs.ending import end
from tests.fuzz_mutations import mutated
from tests.fuzz_readers import READERS, Reader

LONGEST_S = 10.0
MOST_KIB = 500 * 1024
BUG = 1


@dataclass
class Found:
    """What a reader has made of its files.

    Attributes:
        codes: how many ended with which exit code.
        slowest_s: seconds that the slowest took.
        growth_kib: by how much the memory grew, at most.
        bugs: sentences, with the number of the case, of those that ended otherwise than allowed.
    """

    codes: Counter[int] = field(default_factory=Counter)
    slowest_s: float = 0.0
    growth_kib: int = 0
    bugs: list[str] = field(default_factory=list)


def memory_kib() -> int:
    """Return the most memory that this process has had."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def fuzz(reader: Reader, count: int, seed: int, folder: Path, first: int = 0) -> Found:
    """Give a reader so many damaged files.

    Args:
        reader: a row of `READERS`.
        count: of files.
        seed: the same gives the same files.
        folder: to work in.
        first: number of the first file.
    """
    samples = reader.samples()
    others = [one for name, other in READERS.items() if name != reader.name
              for one in (other.samples()[0],)]  # fmt: skip
    read = reader.prepare(folder)
    found = Found()
    for number in range(first, first + count):
        rng = random.Random(f"{seed} {reader.name} {number}")
        data = mutated(rng.choice(samples), rng, others)
        before_kib, began_s = memory_kib(), time.monotonic()
        told = io.StringIO()
        try:
            read(data)
            code = 0
        except BaseException as error:
            if isinstance(error, KeyboardInterrupt):
                raise
            with contextlib.redirect_stderr(told):
                code = end(error, ["-v"])
        took_s, grew_kib = time.monotonic() - began_s, memory_kib() - before_kib
        found.codes[code] += 1
        found.slowest_s = max(found.slowest_s, took_s)
        found.growth_kib = max(found.growth_kib, grew_kib)
        words = told.getvalue()
        if code == BUG or took_s > LONGEST_S or grew_kib > MOST_KIB or len(words) > 5_000:
            why = words if code == BUG else words[:200]
            found.bugs.append(
                f"{reader.name} {number}: code {code}, {took_s:.1f} s, {grew_kib} KiB: {why}"
            )
    return found


def main() -> int:
    """Fuzz the readers that are named, or all, and print a line for each."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=2_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--reader", action="append", choices=list(READERS))
    given = parser.parse_args()
    bad = 0
    for name in given.reader or READERS:
        with tempfile.TemporaryDirectory() as folder:
            found = fuzz(READERS[name], given.count, given.seed, Path(folder), given.first)
        codes = ", ".join(f"{code}: {count}" for code, count in sorted(found.codes.items()))
        sys.stdout.write(
            f"{name:13} {given.count:>6} files; by exit code {codes}; slowest "
            f"{found.slowest_s:.2f} s, memory +{found.growth_kib // 1024} MB\n"
        )
        for bug in found.bugs[:5]:
            sys.stdout.write(f"  {bug}\n")
        sys.stdout.flush()
        bad += len(found.bugs)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
