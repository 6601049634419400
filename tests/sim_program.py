"""A program that plays a fixed batch of episodes and prints digests: `test_sim_bits` runs it.

Every random number is a double of `Generator.random`, so the batch is the same with any NumPy.
"""

import hashlib
import json
import math
import sys

import numpy as np
from numpy.typing import NDArray

from cgagen.words import GENOME_BITS
from sim import batch
from sim.episode import play_recorded
from sim.model import World, words_of
from sim.numbers import Options
from tests.pursuit import hunter_bits, shipped

RANDOMS, HUNTERS, STARTS = 40, 39, 9  # 711 episodes: not a multiple of the lanes
PLAIN = 4
"""Genomes, and starts, of the part that plain Python plays as well."""

ON_ONE_POINT = (10.6, 10.6, -1.0, 0.0, 10.6, 10.6, 0.0, 1.0)


def digest(*arrays: NDArray[np.generic]) -> str:
    """Return the SHA-256 of arrays, little-endian on every machine."""
    whole = hashlib.sha256()
    for array in arrays:
        whole.update(np.ascontiguousarray(array, array.dtype.newbyteorder("<")).tobytes())
    return whole.hexdigest()


def fixed_batch(world: World) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return the words and the starts of the batch."""
    rng = np.random.Generator(np.random.Philox(key=20_240_601))
    randoms = (rng.random((RANDOMS, GENOME_BITS)) < 0.5).astype(np.uint8)
    words = words_of(np.concatenate([hunter_bits(rng, HUNTERS), randoms]))
    return words, world.draw_starts(rng, STARTS)


def from_one_point() -> str:
    """Play both robots from one point, where no bearing is defined; return a digest."""
    world = World(*shipped(), Options(after_capture="go_on"), steps=20)
    words, _ = fixed_batch(world)
    start = np.array([ON_ONE_POINT])
    played = world.play(np.ascontiguousarray(words[:, :1]), start)
    return digest(*played, *play_recorded(words[:, 0], start, world.steps, world.numbers))


def small_part() -> dict[str, object]:
    """Play what plain Python can, and return it in full."""
    world = World(*shipped())
    words, starts = fixed_batch(world)
    words, starts = np.ascontiguousarray(words[:, :PLAIN]), starts[:PLAIN]
    scores, caught = world.play(words, starts)
    poses, looks = play_recorded(words[:, 0], starts[:1], 60, world.numbers)
    return {
        "scores": [float(score).hex() for score in scores],
        "caught": caught.tolist(),
        "record": digest(poses, looks),
        "one point": from_one_point(),
    }


def whole_batch() -> dict[str, object]:
    """Play the batch and return digests, and what the machine code is made of."""
    world = World(*shipped())
    words, starts = fixed_batch(world)
    scores, caught = world.play(words, starts)
    code = "".join(batch.play.inspect_asm().values())  # type: ignore[attr-defined]
    return {
        "digest": digest(starts, scores, caught),
        "zmm": code.count("%zmm"),
        "ymm": code.count("%ymm"),
        "fused": code.count("vfmadd") + code.count("vfmsub") + code.count("vfnmadd"),
        "libm": digest(np.array([math.sin(n * 0.37) + math.exp(n * 0.01) for n in range(9999)])),
    }


if __name__ == "__main__":
    # The results do not depend on the lanes; plain Python does not wait for empty ones.
    if sys.argv[1] == "plain":
        batch.LANES = 3
    print(json.dumps(small_part() if sys.argv[1] == "plain" else whole_batch()))  # noqa: T201
