"""Runs of pytest with the plugin, in folders of others."""

import io
import os
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path

import pytest

FIRMWARE = Path(__file__).parent.parent / "firmware"


def run(folder: Path, *words: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run pytest in a folder, as its owner would."""
    kept = {key: value for key, value in os.environ.items() if not key.startswith("CGAGEN_HIL")}
    return subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *words],
        cwd=folder,
        env={**kept, **environment},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
        stdin=subprocess.DEVNULL,
    )


@dataclass
class Ended:
    """What `run` returns, as far as it is looked at."""

    returncode: int
    stdout: str
    stderr: str


def inside(folder: Path, *words: str, **environment: str) -> Ended:
    """Run pytest likewise in this process: what it imports is here already."""
    # A user's test_robot.py is not ours of that name.
    ours = {name: sys.modules.pop(name) for name in [*sys.modules] if name.startswith("test_")}
    path = list(sys.path)
    out, err = io.StringIO(), io.StringIO()
    plain = ("-q", "-p", "no:cacheprovider", "-p", "no:faulthandler", "--capture=sys")
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(out), redirect_stderr(err):
        patch.chdir(folder)
        for key in [key for key in os.environ if key.startswith("CGAGEN_HIL")]:
            patch.delenv(key)
        for key, value in environment.items():
            patch.setenv(key, value)
        code = int(pytest.main([*plain, "--rootdir", str(folder), *words]))
    sys.path[:] = path
    for name in [name for name in sys.modules if name.startswith("test_")]:
        del sys.modules[name]
    sys.modules.update(ours)
    return Ended(code, out.getvalue(), err.getvalue())
