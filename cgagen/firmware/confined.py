"""Templates of a user's, filled in by a process of their own that has an end in any case.

The sandbox keeps a template from other things; only another process keeps it from an endless loop
or from all of the memory. Words go there as a pickle of ours, and the text comes back as JSON.
"""

import json
import os
import pickle
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from cgagen.errors import TemplateError
from cgagen.firmware.sandbox import Rendered, render
from cgagen.inputs import MIB

LIMIT_S = 10
"""Ours take some 0.05 s. Choice."""

LIMIT_BYTES = 480 * MIB
"""Of the process's address space; it needs some 150 MB. Choice."""


def render_confined(folders: list[Path], name: str, words: Mapping[str, Any]) -> Rendered:
    """Return a template filled in; see `cgagen.firmware.sandbox.render`.

    Raises:
        TemplateError: likewise; or it does not come to its end, or takes too much memory.
    """
    order = pickle.dumps(([str(folder.absolute()) for folder in folders], name, dict(words)))
    # -P: a json.py in the folder that the user works in is not ours to run.
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(one for one in sys.path if one)}
    try:
        done = subprocess.run(
            [sys.executable, "-P", "-m", "cgagen.firmware.confined"],
            input=order,
            capture_output=True,
            env=environment,
            timeout=2 * LIMIT_S,
            check=False,
        )
        answer = json.loads(done.stdout)
    except (subprocess.TimeoutExpired, ValueError) as error:
        raise TemplateError(
            f"{folders[0] / name}: does not come to its end in {LIMIT_S} s and "
            f"{LIMIT_BYTES // MIB} MB; look for a loop that goes on for ever, and make less of it"
        ) from error
    if "error" in answer:
        raise TemplateError(answer["error"])
    origins = [(str(file), int(line)) for file, line in answer["origins"]]
    return Rendered(answer["text"], origins, answer["digests"])


def main() -> None:
    """Fill in the template that stdin says."""
    import resource

    order = sys.stdin.buffer.read()
    resource.setrlimit(resource.RLIMIT_CPU, (LIMIT_S, LIMIT_S))
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))
    if sys.platform.startswith("linux"):
        resource.setrlimit(resource.RLIMIT_AS, (LIMIT_BYTES, LIMIT_BYTES))
    folders, name, words = pickle.loads(order)
    try:
        answer: dict[str, Any] = render([Path(one) for one in folders], name, words)._asdict()
    except TemplateError as error:
        answer = {"error": str(error)}
    sys.stdout.write(json.dumps(answer))


if __name__ == "__main__":
    main()
