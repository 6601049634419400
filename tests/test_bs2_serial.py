"""Parallax's own JavaScript programmer against the emulated programming port.

It is npm's bs2-serial 0.15.0 as it is, compiler and terminal included; only its transport, which
is made for Chrome, is ours (npm/client.cjs). `make clients` fetches it.

It asserts DTR and leaves it so: that works where a capacitor lies between DTR and ATN, as on most
boards and, unless something else is asked for, on ours.
"""

import json
import subprocess
from contextlib import ExitStack
from typing import Any, NamedTuple

import pytest

from cgagen.emulator.bench import Bench
from cgagen.emulator.programs import bench_of_image
from cgagen.serve import Atn, Server, serve
from cgagen.stamp.chips import CHIPS, EEPROM_BYTES, chip
from cgagen.stamp.image import Image
from cgagen.tokenizer import Tokenizer
from cgagen.toolchain import find_node
from tests.npm.fetch import HERE, modules

LIMIT_S = 120
SOURCE = """' {$STAMP %s}
x VAR BYTE
x = x + 42
DEBUG "I am %s ", DEC x, CR
END
"""


def erased(model: str) -> Bench:
    return bench_of_image(Image(chip(model), bytes(EEPROM_BYTES)))


def programmer(*jobs: dict[str, Any]) -> list[dict[str, Any]]:
    """Let it do jobs, one after the other, in one process."""
    assert modules().is_dir(), "run `make clients` once"
    done = subprocess.run(
        [str(find_node().path), "--no-deprecation", str(HERE / "client.cjs"), str(modules())],
        input=json.dumps(jobs),
        capture_output=True,
        text=True,
        timeout=LIMIT_S,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    results: list[dict[str, Any]] = json.loads(done.stdout)
    return results


def identify(server: Server, model: str) -> dict[str, Any]:
    return {
        "what": "identify",
        "place": server.url.removeprefix("socket://"),
        "control": server.control,
        "revision": model.lower(),
    }


def bootload(server: Server, model: str) -> dict[str, Any]:
    text = f"I am {model} 42<linefeed>"
    job = {"what": "bootload", "source": SOURCE % (model.upper(), model), "wanted": text}
    return {**identify(server, model), **job}


def test_the_lock_pins_every_package_and_names_no_host() -> None:
    text = (HERE / "package-lock.json").read_text("utf-8")
    packages = json.loads(text)["packages"]
    assert packages["node_modules/bs2-serial"]["version"] == "0.15.0"
    assert all(one["integrity"].startswith("sha512-") for name, one in packages.items() if name)
    assert "resolved" not in text
    assert "://" not in text


class Session(NamedTuple):
    """What the programmer found on an erased chip, loaded and heard; and what the chip holds."""

    found: dict[str, Any]
    loaded: dict[str, Any]
    eeprom: bytes


@pytest.fixture(scope="module")
def sessions() -> dict[str, Session]:
    """All models, one after the other."""
    benches = {row.name: erased(row.name) for row in CHIPS}
    jobs: list[dict[str, Any]] = []
    with ExitStack() as stack:
        for model, bench in benches.items():
            server = stack.enter_context(serve(bench, "tcp:0"))
            jobs += [identify(server, model), bootload(server, model)]
        results = iter(programmer(*jobs))
        assert server.failure is None
    return {
        model: Session(next(results), next(results), bench.chip("main").eeprom())
        for model, bench in benches.items()
    }


@pytest.mark.parametrize("row", CHIPS, ids=lambda row: row.name)
def test_it_identifies_loads_and_hears_every_model(
    row: Any, sessions: dict[str, Session], tokenizer: Tokenizer
) -> None:
    found, loaded, eeprom = sessions[row.name]
    slots = {} if row.name == "BS2" else {"slotCount": 8}
    assert found == {"board": {"name": row.name, "version": "1.0", **slots}}
    assert f"I am {row.name} 42<linefeed>" in loaded["heard"]
    assert loaded["progress"][-1] > 30
    assert eeprom == tokenizer.compile(SOURCE % (row.directive, row.name)).image.eeprom


VERSIONS = [
    # model, legs, place among the versions, what the programmer makes of it
    ("BS2e", 24, 2, "1.2"),
    ("BS2sx", 24, 3, "1.3"),
    ("BS2p", 24, 7, "1.7"),
    ("BS2p", 40, 7, "1.7"),
    ("BS2pe", 24, 4, "1.4"),
    ("BS2pe", 40, 4, "1.4"),
]


def test_it_knows_the_newest_versions_and_both_sizes() -> None:
    jobs = []
    with ExitStack() as stack:
        for model, legs, version, _ in VERSIONS:
            server = serve(erased(model), legs=legs, version=version)
            jobs.append(identify(stack.enter_context(server), model))
        results = programmer(*jobs)
    for found, (model, _, _, said) in zip(results, VERSIONS, strict=True):
        assert found == {"board": {"name": model, "version": said, "slotCount": 8}}


def test_it_works_on_a_pty() -> None:
    with serve(erased("BS2"), "pty") as server:
        found, loaded = programmer(identify(server, "BS2"), bootload(server, "BS2"))
    assert found["board"] == {"name": "BS2", "version": "1.0"}
    assert "I am BS2 42<linefeed>" in loaded["heard"]


def test_it_says_itself_what_is_wrong() -> None:
    """Its own sentences: another model, an EEPROM that does not take a block, a held reset."""
    with serve(erased("BS2")) as server:
        (silent,) = programmer(identify(server, "BS2sx"))
        server.endpoints[0].port.port.loader.bad_blocks = frozenset({127})
        (bad,) = programmer(bootload(server, "BS2"))
    assert "Board did not respond" in silent["error"]
    assert bad["error"].startswith("Board nacked packet")
    assert bad["error"].endswith("with code: 2")
    with serve(erased("BS2"), atn=Atn.DIRECT) as server:
        (held,) = programmer(identify(server, "BS2"))
    assert held["error"] == "Board did not respond, check power and connection."
