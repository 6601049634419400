"""Locks on ports: in a folder of the user's own, and gone with their session."""

import os
import socket
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from cgagen.errors import RigError
from cgagen.link.lock import PortLock, lock_folder
from tests.output_cases import null_device

PORT = "/dev/port-of-a-test"


@pytest.fixture(autouse=True)
def own_folders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path / "run"))
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    (tmp_path / "home").mkdir()
    (tmp_path / "run").mkdir(mode=0o700)


def taken() -> PortLock:
    lock = PortLock(PORT)
    lock.take()
    return lock


def test_a_lock_lives_as_long_as_its_session(tmp_path: Path) -> None:
    before = os.umask(0)
    try:
        lock = taken()
    finally:
        os.umask(before)
    [file] = lock_folder().iterdir()
    assert lock_folder() == tmp_path / "run" / "cgagen" / "ports"
    assert stat.S_IMODE(lock_folder().stat().st_mode) == 0o700
    assert stat.S_IMODE(file.stat().st_mode) == 0o600
    with pytest.raises(RigError, match="another session of cgagen has this port"):
        taken()
    lock.release()
    lock.release()
    assert not list(lock_folder().iterdir())
    taken().release()


def test_a_killed_sessions_lock_is_free() -> None:
    code = (
        f"from cgagen.link.lock import PortLock; import os; PortLock({PORT!r}).take(); os.abort()"
    )
    words = ["-c", f"import resource; resource.setrlimit(4, (0, 0)); {code}"]
    subprocess.run([sys.executable, *words], stdin=subprocess.DEVNULL, check=False, timeout=60)
    assert len(list(lock_folder().iterdir())) == 1
    taken().release()
    assert not list(lock_folder().iterdir())


@pytest.mark.parametrize("mode", [0o755, 0o770, 0o1777])
def test_a_folder_of_others_is_no_place(tmp_path: Path, mode: int) -> None:
    (tmp_path / "run").chmod(mode)
    assert lock_folder() == tmp_path / "home" / ".cache" / "cgagen" / "ports"
    assert not list((tmp_path / "run").iterdir())


def test_a_relative_folder_is_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", "run")
    monkeypatch.chdir(tmp_path)
    assert lock_folder().is_relative_to(tmp_path / "home")


@pytest.mark.parametrize("what", ["link", "pipe", "folder", "device", "socket"])
def test_what_stands_in_the_locks_place_is_neither_followed_nor_waited_for(
    tmp_path: Path, what: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    taken().release()
    name = PortLock(PORT)._name
    place, target = lock_folder() / name, tmp_path / "precious"
    target.write_text("of the user's")
    if what == "link":
        place.symlink_to(target)
    elif what == "pipe":
        os.mkfifo(place)
    elif what == "folder":
        place.mkdir()
    elif what == "socket":
        monkeypatch.chdir(place.parent)
        with socket.socket(socket.AF_UNIX) as one:
            one.bind(name)
    else:
        null_device(place)
    before = place.lstat()
    with pytest.raises(RigError, match="no lock can be had for it"):
        taken()
    assert target.read_text() == "of the user's"
    assert place.lstat().st_ino == before.st_ino


def test_a_folder_that_is_a_link_is_refused(tmp_path: Path) -> None:
    (tmp_path / "elsewhere").mkdir(mode=0o700)
    (tmp_path / "run" / "cgagen").mkdir()
    (tmp_path / "run" / "cgagen" / "ports").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(RigError, match="not a folder of this user's alone"):
        taken()
    assert not list((tmp_path / "elsewhere").iterdir())


def test_nobodys_home_is_a_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", "")
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("HOME", str(tmp_path / "file"))
    with pytest.raises(RigError, match="set XDG_RUNTIME_DIR to a folder of your own"):
        taken()
