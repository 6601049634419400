"""Compiled kernels on the disk: damage costs a compilation, and nothing of others is run."""

import os
import pickle
import stat
import subprocess
import sys
from pathlib import Path
from typing import Any

import numba
import pytest

from cgagen.caches import TROUBLE, trouble_of_stat, user_cache
from cgagen.errors import StorageError
from sim import kernel_cache
from sim.jit import cache_folder
from sim.kernel_cache import MAGIC, SUFFIX, KernelCache

ADD = """
import sys
from pathlib import Path
import numba
from sim.kernel_cache import KernelCache

def add(a, b):
    return a + b

one = numba.njit(add)
one._cache = KernelCache(add, Path(sys.argv[1]))
assert one(2, 3) == 5
print(sum(one._cache_hits.values()))
"""


def add(a: int, b: int) -> int:
    return a + b


def compiled(folder: Path | None) -> Any:
    one: Any = numba.njit(add)
    one._cache = KernelCache(add, folder)
    return one


def hits(folder: Path | None) -> int:
    """How many kernels were loaded by a call, which has to be right in any case."""
    one = compiled(folder)
    assert one(2, 3) == 5
    return sum(one._cache_hits.values())


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A cache with one kernel in it."""
    TROUBLE.seen.clear()
    place = tmp_path / "cgagen" / "kernel-1"
    assert hits(place) == 0
    assert hits(place) == 1
    assert TROUBLE.seen == []
    return place


def kernel_in(folder: Path) -> Path:
    (path,) = folder.glob(f"*{SUFFIX}")
    return path


def test_the_folder_is_for_the_user_alone(folder: Path) -> None:
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700


@pytest.mark.parametrize("cut", [0, 1, len(MAGIC), len(MAGIC) + 32, 4_000, -1])
def test_a_cut_file_is_compiled_again_and_written_again(folder: Path, cut: int) -> None:
    path = kernel_in(folder)
    path.write_bytes(path.read_bytes()[:cut])
    assert hits(folder) == 0
    assert "it is damaged; compiling again" in TROUBLE.seen[0]
    assert hits(folder) == 1


def test_every_flipped_bit_is_noticed(folder: Path) -> None:
    path = kernel_in(folder)
    content = path.read_bytes()
    cache = KernelCache(add, folder)
    for place in range(0, len(content), 97):
        damaged = bytearray(content)
        damaged[place] ^= 1 << place % 8
        path.write_bytes(bytes(damaged))
        with pytest.raises(ValueError, match="damaged"):
            cache._payload(path)


class Bomb:
    """Is armed by being unpickled."""

    def __reduce__(self) -> tuple[Any, ...]:
        return (os.system, ("touch armed",))


def test_a_pickle_without_a_digest_is_not_unpickled(folder: Path, monkeypatch, tmp_path) -> None:
    monkeypatch.chdir(tmp_path)
    kernel_in(folder).write_bytes(MAGIC + bytes(32) + pickle.dumps(Bomb()))
    assert hits(folder) == 0
    assert not (tmp_path / "armed").exists()


@pytest.mark.parametrize("mode", [0o702, 0o777, 0o1777])
def test_a_folder_that_others_can_write_is_not_used(folder: Path, mode: int) -> None:
    folder.chmod(mode)
    before = kernel_in(folder).read_bytes()
    assert hits(folder) == 0
    assert "all users can write it" in TROUBLE.seen[0]
    assert kernel_in(folder).read_bytes() == before


def test_a_file_that_others_can_write_is_not_used(folder: Path) -> None:
    kernel_in(folder).chmod(0o666)
    assert hits(folder) == 0
    assert "all users can write it" in TROUBLE.seen[0]


def test_what_belongs_to_another_is_not_used(folder: Path, monkeypatch) -> None:
    found = folder.stat()
    assert trouble_of_stat(found) == ""
    monkeypatch.setattr("os.geteuid", lambda: found.st_uid + 1)
    assert trouble_of_stat(found) == "it belongs to another user"
    assert hits(folder) == 0


def test_a_link_and_a_pipe_are_not_followed(folder: Path, tmp_path) -> None:
    path = kernel_in(folder)
    path.rename(tmp_path / "elsewhere")
    path.symlink_to(tmp_path / "elsewhere")
    assert hits(folder) == 0
    path.unlink()
    os.mkfifo(path)
    assert hits(folder) == 0
    assert len(TROUBLE.seen) >= 2


def test_a_full_disk_means_no_cache(tmp_path: Path, monkeypatch) -> None:
    def refuse(path: Path, _data: bytes) -> None:
        raise StorageError(f"{path}: cannot be written (No space left on device)")

    monkeypatch.setattr(kernel_cache, "write_bytes", refuse)
    TROUBLE.seen.clear()
    assert hits(tmp_path / "kernel-1") == 0
    assert "No space left" in TROUBLE.seen[0]


def _a_file(path: Path) -> Path:
    path.write_text("here already")
    return path


def _below_a_file(path: Path) -> Path:
    return _a_file(path) / "kernel-1"


def _no_home(_path: Path) -> None:
    return None


@pytest.mark.parametrize("make", [_a_file, _below_a_file, _no_home])
def test_a_place_that_cannot_be_a_folder_means_no_cache(tmp_path: Path, make) -> None:
    place = make(tmp_path / "cgagen")
    assert hits(place) == hits(place) == 0


def test_the_first_trouble_is_told_to_who_asked(folder: Path) -> None:
    told: list[str] = []
    TROUBLE.tell = told.append
    try:
        kernel_in(folder).write_bytes(b"")
        folder.chmod(0o777)
        hits(folder)
    finally:
        TROUBLE.tell = None
    assert len(told) == 1
    assert len(TROUBLE.seen) == 2
    assert told[0].startswith("note: a file of the cache is not used: ")


def test_kernels_of_other_versions_do_not_meet(folder: Path, monkeypatch) -> None:
    monkeypatch.setattr(numba, "__version__", "9.9")
    assert hits(folder) == 0
    assert len(list(folder.glob(f"*{SUFFIX}"))) == 2


def test_first_starts_at_the_same_time(tmp_path: Path) -> None:
    """Each compiles, writes whole files, and none sees half of another's."""
    program = tmp_path / "add.py"
    program.write_text(ADD)
    words = [sys.executable, str(program), str(tmp_path / "cgagen" / "kernel-1")]
    root = Path(__file__).parent.parent
    environment = os.environ | {"PYTHONPATH": str(root)}
    running = [
        subprocess.Popen(words, env=environment, stdout=subprocess.PIPE, stdin=subprocess.DEVNULL)
        for _ in range(3)
    ]
    assert [one.communicate(timeout=300)[0] for one in running]
    assert [one.returncode for one in running] == [0, 0, 0]
    last = subprocess.run(
        words, env=environment, capture_output=True, check=True, text=True, stdin=subprocess.DEVNULL
    )
    assert last.stdout == "1\n"
    assert sorted((tmp_path / "cgagen" / "kernel-1").iterdir()) == [
        kernel_in(tmp_path / "cgagen" / "kernel-1")
    ]


@pytest.mark.parametrize(
    ("variables", "wanted"),
    [
        ({"XDG_CACHE_HOME": "/var/x"}, "/var/x/cgagen"),
        ({"XDG_CACHE_HOME": "relative", "HOME": "/home/me"}, "/home/me/.cache/cgagen"),
        ({"XDG_CACHE_HOME": "", "HOME": "/home/me"}, "/home/me/.cache/cgagen"),
    ],
)
def test_where_caches_lie(monkeypatch, variables: dict[str, str], wanted: str) -> None:
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    assert user_cache() == Path(wanted)
    folder = cache_folder()
    assert folder is not None
    assert folder.parent == Path(wanted)
    monkeypatch.setenv("NUMBA_CACHE_DIR", "/opt/kernels")
    folder = cache_folder()
    assert folder is not None
    assert folder.parent == Path("/opt/kernels")


def test_a_user_without_a_home_has_no_cache(monkeypatch) -> None:
    def nobody() -> Path:
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.setattr(Path, "home", nobody)
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    assert user_cache() is None
    assert cache_folder() is None
