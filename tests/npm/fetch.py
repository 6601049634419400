"""Parallax's JavaScript programmer for the tests, from npm by a lock file with hashes.

``python -m tests.npm.fetch`` (``make clients``) puts it into the user's cache once.
"""

import shutil
import subprocess
import sys
from pathlib import Path

from cgagen.files import digest
from cgagen.temporaries import temporary_folder
from cgagen.toolchain import find_node, tokenizer_path
from cgagen.toolchain.node import clean_environment

HERE = Path(__file__).parent
LIMIT_S = 180


def modules() -> Path:
    """Return where the packages of this lock file are, whether they are there or not."""
    lock = digest((HERE / "package-lock.json").read_bytes())
    return tokenizer_path().parent.parent / f"test-clients-{lock[:12]}" / "node_modules"


def fetch() -> int:
    """Fetch them unless they are there; returns an exit code."""
    target = modules().parent
    if modules().is_dir():
        return 0
    target.parent.mkdir(parents=True, exist_ok=True)
    with temporary_folder(target.parent) as work:
        for name in ("package.json", "package-lock.json"):
            shutil.copy(HERE / name, work / name)
        done = subprocess.run(
            [*find_node().npm(), "ci", "--ignore-scripts", "--no-audit", "--no-fund"],
            cwd=work,
            env=clean_environment(),
            capture_output=True,
            text=True,
            timeout=LIMIT_S,
            check=False,
            stdin=subprocess.DEVNULL,
        )
        if done.returncode:
            sys.stderr.write(done.stderr)
            return done.returncode
        work.rename(target)
    return 0


if __name__ == "__main__":
    raise SystemExit(fetch())
