"""Another program that has a port open."""

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def opened_by_another(name: str, how: str) -> Iterator[int]:
    """Keep a port open in a process of its own; give the process's number.

    Args:
        name: of the port.
        how: Python that opens it, as `sys.argv[1]`.
    """
    code = f"import serial, sys; port = {how}; print('open', flush=True); sys.stdin.read()"
    other = subprocess.Popen(
        [sys.executable, "-c", code, name], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    try:
        assert other.stdout is not None
        assert other.stdout.readline() == b"open\n"
        yield other.pid
    finally:
        other.communicate()
