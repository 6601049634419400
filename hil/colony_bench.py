"""Two robots as one bench: both `bench.toml`, each with its robot's name before every name.

The predator's main controller becomes `predator_main`, its P4 `predator_main.P4`, its front sonar
`predator_sonar_front`; no wire goes from one robot to the other, and each robot's sonars hear their
own robot's bursts alone unless `share_air` is called.
"""

import tomllib
from collections.abc import Mapping
from typing import Any

import tomli_w

from cgagen.build.bench import BENCH_FORMAT, bench_text
from cgagen.emulator.bench import Bench
from cgagen.emulator.bench_file import parse_bench
from cgagen.emulator.parts.air import Air
from cgagen.emulator.parts.sonar import Sonar
from cgagen.temporaries import temporary_folder
from hil.benches import show
from hil.forced import LATE_NS
from hil.subject import CHIPS, Subject


def colony_text(texts: Mapping[str, str]) -> str:
    """Return one bench file of several, by the word that comes before each one's names.

    Sources are left out: the images run.

    >>> one = 'format = "cgagen-bench-1"' + chr(10) + '[wire.w]' + chr(10) + 'ends = ["a.P0"]'
    >>> print(colony_text({"prey": one}).split(chr(10))[2])
    [wire.prey_w]
    """
    sections: dict[str, dict[str, Any]] = {}
    for word, text in texts.items():
        for section, tables in tomllib.loads(text).items():
            if not isinstance(tables, dict):
                continue
            for name, table in tables.items():
                sections.setdefault(section, {})[f"{word}_{name}"] = _named(word, table)
    return tomli_w.dumps({"format": BENCH_FORMAT, **sections})


_NAMES = ("image", "ends", "end", "part", "wire", "wires", "chips", "sonars")
"""Keys whose values are names, or lists of them."""


def _named(word: str, table: dict[str, Any]) -> dict[str, Any]:
    """Return a chip, a wire, a part or a fault in which every name bears the word."""
    named = {key: value for key, value in table.items() if key != "source"}
    for key in _NAMES:
        if isinstance(named.get(key), str):
            named[key] = f"{word}_{named[key]}"
        elif key in named:
            named[key] = [f"{word}_{one}" for one in named[key]]
    return named


def colony_bench(subjects: Mapping[str, Subject], texts: Mapping[str, str] | None = None) -> Bench:
    """Return the bench of both robots with their images in their chips.

    Args:
        subjects: by the word that comes before their names.
        texts: other benches than the robots' own, for faults in the wiring.

    Raises:
        BenchError: a bench that cannot be.
    """
    texts = texts or {word: bench_text(subject.robot) for word, subject in subjects.items()}
    with temporary_folder() as folder:
        for word, subject in subjects.items():
            for name in CHIPS:
                file = folder / f"{word}_{name}.bin"
                file.write_bytes(subject.images[name].eeprom)
        bench = parse_bench(colony_text(texts), "bench.toml", folder)
    images = {
        f"{word}_{name}": subject.images[name]
        for word, subject in subjects.items()
        for name in CHIPS
    }
    return show(bench, images)


def share_air(bench: Bench) -> Air:
    """Let the sonars of all robots on a bench hear one another's bursts; returns what they share.

    Nothing on the robots keeps their sonars apart then, so they read what is not there
    (FIDELITY.md); that is why it is asked for.
    """
    room = bench.add_part(Air("room", bench.clock, tuple(bench.parts_of(Sonar).values())))
    room.see_echoes(*LATE_NS)
    return room
