"""The same bits everywhere: threads, plain Python, narrower vectors, a library without FMA.

The other ways run in processes of their own, one after the other, once per session. Their
machine code is kept in pytest's cache, by the digest of the sources, so a second run is short.
"""

import json
import os
import platform
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import llvmlite.binding
import numpy as np
import pytest

from sim.episode import play_recorded
from sim.jit import cache_folder
from sim.model import World
from tests import sim_program
from tests.pursuit import shipped

GOLDEN_BATCH = "f34501bea079bcfe3d382536c283aa0a7096e790759bc405caaf247b480278bc"
"""Starts, scores and steps of capture of 711 episodes; `python tests/sim_program.py batch`."""

GOLDEN_RECORD = "d5230c8067e7d2aae4ada685b316e22c918918abcf20e282fb2f4756cff8422c"
"""Poses and looks of 60 steps; `python tests/sim_program.py plain`.

Both change with every number of the shipped robots and with every operation of the step. If that
was meant, put the new ones here and say so in CHANGELOG.md: scores of old runs no longer compare.
"""

X86 = platform.machine() in ("x86_64", "AMD64")
FEATURES: dict[str, bool] = dict(llvmlite.binding.get_host_cpu_features())

NO_FMA_IN_LIBM = "glibc.cpu.hwcaps=-AVX,-AVX2,-FMA,-FMA4,-AVX512F,-AVX2_Usable,-FMA_Usable"


def run(argument: str, **environment: str) -> dict[str, Any]:
    done = subprocess.run(
        [sys.executable, sim_program.__file__, argument],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
        stdin=subprocess.DEVNULL,
    )
    assert done.returncode == 0, done.stderr
    answer: dict[str, Any] = json.loads(done.stdout)
    return answer


def compile_for(cpu: str, features: str, cache: Path) -> dict[str, Any]:
    """Run the batch in code for another CPU; remember what that code is made of.

    Numba shows the code only when it has just made it, so that is kept beside its cache.
    """
    note = cache / "code.json"
    if not note.exists():
        shutil.rmtree(cache, ignore_errors=True)
    answer = run(
        "batch",
        NUMBA_CACHE_DIR=str(cache),
        NUMBA_CPU_NAME=cpu,
        NUMBA_CPU_FEATURES=features,
        PYTHONWARNINGS="ignore:Inspection disabled",
    )
    if not note.exists():
        note.write_text(json.dumps(answer), "utf-8")
    return {**json.loads(note.read_text("utf-8")), "digest": answer["digest"]}


@pytest.fixture(scope="session")
def cache(request: pytest.FixtureRequest) -> Path:
    """A folder for machine code, named by the sources; those of older sources are removed."""
    base = request.config.cache
    assert base is not None
    folder = base.mkdir("kernels")
    ours = cache_folder()
    assert ours is not None
    mine = folder / ours.name
    for old in folder.iterdir():
        if old != mine:
            shutil.rmtree(old, ignore_errors=True)
    return Path(mine)


@pytest.fixture(scope="session")
def narrow(cache: Path) -> dict[str, Any]:
    """The batch in code for the oldest CPU of this kind: two numbers at a time."""
    return compile_for("generic", "", cache / "generic")


@pytest.fixture(scope="session")
def without_avx512(cache: Path) -> dict[str, Any]:
    """The batch in code with AVX2 and FMA, but no AVX-512."""
    if not (X86 and FEATURES.get("avx2") and FEATURES.get("fma")):
        pytest.skip("this CPU has no AVX2")
    flags = [
        f"+{name}" if has and not name.startswith("avx512") else f"-{name}"
        for name, has in sorted(FEATURES.items())
    ]
    return compile_for("haswell", ",".join(flags), cache / "avx2")


@pytest.fixture(scope="session")
def here() -> dict[str, Any]:
    """The batch in this process."""
    return sim_program.whole_batch()


@pytest.fixture(scope="session")
def plain() -> dict[str, Any]:
    """The small part in plain Python; its warnings are errors."""
    return run("plain", NUMBA_DISABLE_JIT="1", PYTHONWARNINGS="error")


@pytest.mark.filterwarnings("ignore:Inspection disabled")
def test_the_batch_is_the_golden_one(here: dict[str, Any]) -> None:
    assert here["digest"] == GOLDEN_BATCH
    assert here["fused"] == 0


def test_the_record_is_the_golden_one() -> None:
    world = World(*shipped())
    words, starts = sim_program.fixed_batch(world)
    poses, looks = play_recorded(words[:, 0], starts[:1], 60, world.numbers)
    assert sim_program.digest(poses, looks) == GOLDEN_RECORD


@pytest.mark.parametrize("threads", [2, 3])
def test_threads_share_the_work_and_change_nothing(threads: int) -> None:
    alone, together = World(*shipped()), World(*shipped(), threads=threads)
    words, starts = sim_program.fixed_batch(alone)
    try:
        for genomes in (words.shape[1], 1, 7):
            some = np.ascontiguousarray(words[:, :genomes])
            scores, caught = alone.play(some, starts)
            shared_scores, shared_caught = together.play(some, starts)
            assert scores.tobytes() == shared_scores.tobytes()
            assert caught.tobytes() == shared_caught.tobytes()
    finally:
        together.close()


def test_an_episode_does_not_depend_on_its_neighbours() -> None:
    world = World(*shipped())
    words, starts = sim_program.fixed_batch(world)
    scores, caught = world.play(words, starts)
    for genome in (0, 13, 78):
        for start in (0, 8):
            alone = np.ascontiguousarray(words[:, genome : genome + 1])
            score, at = world.play(alone, starts[start : start + 1])
            episode = genome * len(starts) + start
            assert score.tobytes() == scores[episode : episode + 1].tobytes()
            assert at[0] == caught[episode]


def test_plain_python_gives_the_same_bits(plain: dict[str, Any]) -> None:
    assert plain == sim_program.small_part()
    assert plain["record"] == GOLDEN_RECORD
    assert any(plain["caught"])
    assert not all(plain["caught"])


def test_vectors_of_two_give_the_same_bits(narrow: dict[str, Any]) -> None:
    assert narrow["digest"] == GOLDEN_BATCH
    assert (narrow["zmm"], narrow["ymm"], narrow["fused"]) == (0, 0, 0)


def test_no_avx512_gives_the_same_bits(without_avx512: dict[str, Any]) -> None:
    assert without_avx512["digest"] == GOLDEN_BATCH
    assert (without_avx512["zmm"], without_avx512["fused"]) == (0, 0)
    assert without_avx512["ymm"] > 100


@pytest.mark.filterwarnings("ignore:Inspection disabled")
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="the switch is glibc's")
def test_a_library_without_fma_gives_the_same_bits(here: dict[str, Any]) -> None:
    other = run("batch", GLIBC_TUNABLES=NO_FMA_IN_LIBM, PYTHONWARNINGS="ignore:Inspection disabled")
    assert other["digest"] == GOLDEN_BATCH
    if X86 and FEATURES.get("fma") and platform.libc_ver()[0] == "glibc":
        # The switch did something: the library's own sine and exponential have other last bits.
        assert other["libm"] != here["libm"]
