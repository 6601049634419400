"""What stands at the name of an output decides how it is written, for every verb alike."""

import errno
import os
import socket
import stat
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from cgagen.cli import main
from cgagen.errors import StorageError
from cgagen.files import live_file, text_stream, write_bytes
from cgagen.places import descriptor_of, place_of
from cgagen.temporaries import is_temporary
from tests.output_cases import Reader, fifo, is_null_device, listening, null_device, pipe_name

BLINK = """' {$STAMP BS2}
i VAR Byte
FOR i = 1 TO 3
  TOGGLE 3
  DEBUG "blink", CR
  PAUSE 10
NEXT
"""

Write = Callable[[Path, bytes], None]


def streamed(path: Path, data: bytes) -> None:
    with text_stream(path) as file:
        file.write(data.decode())


def live(path: Path, data: bytes) -> None:
    with live_file(path) as file:
        file.write(data)


WAYS = pytest.mark.parametrize("write", [write_bytes, streamed, live])


@WAYS
def test_a_device_stays_one(tmp_path: Path, write: Write) -> None:
    device = null_device(tmp_path / "null")
    link = tmp_path / "link"
    link.symlink_to(device)
    for path in (device, link):
        write(path, b"gone")
        assert is_null_device(device)
    assert sorted(os.listdir(tmp_path)) == ["link", "null"]


@WAYS
def test_streams_get_the_bytes(tmp_path: Path, write: Write) -> None:
    with fifo(tmp_path / "fifo") as reader:
        write(tmp_path / "fifo", b"through a named pipe")
        assert reader.text() == b"through a named pipe"
    assert stat.S_ISFIFO((tmp_path / "fifo").stat().st_mode)
    with pipe_name() as (name, reader):
        write(Path(name), b"through ")
        write(Path(name.replace("/dev/fd", "/proc/self/fd")), b"a pipe")
    assert reader.text() == b"through a pipe"
    with listening() as (path, reader):
        write(path, b"through a socket")
        assert reader.text() == b"through a socket"
        assert stat.S_ISSOCK(path.stat().st_mode)
    assert os.listdir(tmp_path) == ["fifo"]


@WAYS
def test_a_descriptor_of_a_file_goes_on_where_it_is(tmp_path: Path, write: Write) -> None:
    """As `> file` with `-o /dev/stdout` has it: what stands there already is not written over."""
    file = tmp_path / "it"
    handle = os.open(file, os.O_WRONLY | os.O_CREAT, 0o600)
    os.write(handle, b"before, ")
    write(Path(f"/dev/fd/{handle}"), b"it")
    os.write(handle, b", behind")
    os.close(handle)
    assert file.read_bytes() == b"before, it, behind"


@WAYS
def test_a_link_is_followed_and_stays(tmp_path: Path, write: Write) -> None:
    (tmp_path / "there").mkdir()
    (tmp_path / "old").write_text("old")
    for name, target in (("to_old", "old"), ("to_new", "there/new"), ("twice", "to_old")):
        (tmp_path / name).symlink_to(target)
        write(tmp_path / name, name.encode())
        assert os.readlink(tmp_path / name) == target
        assert (tmp_path / target).read_text() == name
    assert (tmp_path / "old").read_text() == "twice"


@WAYS
def test_what_is_no_file_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, write: Write
) -> None:
    (tmp_path / "loop").symlink_to("pool")
    (tmp_path / "pool").symlink_to("loop")
    (tmp_path / "stray").symlink_to("nowhere/at/all")
    wrong = {
        ".": "it is a folder",
        "loop": "leads to itself",
        "stray": "there is no folder",
        "no/such": "there is no folder",
        "nul\0": "no file can have such a name",
        "n" * 300: "name too long",
        "/dev/fd/987654": "nothing is open there",
        "deaf": "Connection refused",
    }
    monkeypatch.chdir(tmp_path)  # a socket's name has to be short
    with socket.socket(socket.AF_UNIX) as nobody:
        nobody.bind("deaf")
    before = sorted(os.listdir(tmp_path))
    for name, words in wrong.items():
        with pytest.raises(StorageError, match=words) as caught:
            write(Path(name), b"x")
        assert len(str(caught.value)) < 900
    assert sorted(os.listdir(tmp_path)) == before


def test_a_disk_is_refused(tmp_path: Path) -> None:
    try:
        os.mknod(tmp_path / "disk", 0o600 | stat.S_IFBLK, os.makedev(7, 250))
    except OSError as error:
        pytest.skip(f"no device can be made here: {error}")
    with pytest.raises(StorageError, match="it is a disk"):
        place_of(tmp_path / "disk")


@WAYS
def test_a_reader_that_has_gone_is_no_refusal_of_the_disk(write: Write) -> None:
    reading, writing = os.pipe()
    os.close(reading)
    with pytest.raises(BrokenPipeError):
        write(Path(f"/dev/fd/{writing}"), b"x")
    os.close(writing)


def test_a_full_device_is_a_sentence() -> None:
    for write in (write_bytes, streamed, live):
        with pytest.raises(StorageError, match="No space left"):
            write(Path("/dev/full"), b"x" * 100_000)


def test_a_stream_that_does_not_wait_gets_all_of_it() -> None:
    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    reader = Reader(reading)
    write_bytes(Path(f"/dev/fd/{writing}"), b"x" * 1_000_000)
    os.close(writing)
    assert len(reader.text()) == 1_000_000
    os.close(reading)


@pytest.mark.parametrize("write", [write_bytes, streamed])
def test_modes_are_kept_and_new_ones_are_the_users(tmp_path: Path, write: Write) -> None:
    file, before = tmp_path / "it", os.umask(0o027)
    try:
        write(file, b"new")
        assert stat.S_IMODE(file.stat().st_mode) == 0o640
        file.chmod(0o600)
        write(file, b"again")
        assert stat.S_IMODE(file.stat().st_mode) == 0o600
    finally:
        os.umask(before)


def test_an_error_of_the_block_is_not_the_disks(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="of the block") as caught, text_stream(tmp_path / "a"):
        raise OSError(errno.ENOSPC, "of the block")
    assert not isinstance(caught.value, StorageError)
    assert [name for name in os.listdir(tmp_path) if is_temporary(name)] == []


def test_a_stream_that_is_torn_apart_leaves_nothing(tmp_path: Path) -> None:
    def torn() -> None:
        with text_stream(tmp_path / "a") as file:
            file.write("half a li")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        torn()
    assert os.listdir(tmp_path) == []


def test_descriptors_have_many_names(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to("/dev/stdout")
    (tmp_path / "more").symlink_to("link")
    for name in ("/dev/stdout", "/dev/fd/1", "/proc/self/fd/1", f"/proc/{os.getpid()}/fd/1"):
        assert descriptor_of(Path(name)) == 1
    assert descriptor_of(tmp_path / "more") == 1
    assert descriptor_of(tmp_path / "1") is None
    assert descriptor_of(Path("/proc/1/fd/1")) is None


def emulated(folder: Path, *words: object) -> int:
    (folder / "it.bs2").write_text(BLINK)
    return main(["emulate", str(folder / "it.bs2"), "--for", "2s", *map(str, words)])


@pytest.mark.parametrize("option", ["--vcd", "--trace", "--coverage"])
def test_emulate_leaves_a_device_in_its_place(tmp_path: Path, option: str) -> None:
    device = null_device(tmp_path / "null")
    assert emulated(tmp_path, option, device) == 0
    assert is_null_device(device)
    assert sorted(os.listdir(tmp_path)) == ["it.bs2", "null"]


@pytest.mark.parametrize(
    ("option", "start"),
    [("--vcd", b"$timescale"), ("--trace", b"time_us,"), ("--coverage", b"TN:cgagen\nSF:")],
)
def test_emulate_writes_to_pipes(tmp_path: Path, option: str, start: bytes) -> None:
    with pipe_name() as (name, reader):
        assert emulated(tmp_path, option, name) == 0
    assert reader.text().startswith(start)
    with fifo(tmp_path / "fifo") as reader:
        assert emulated(tmp_path, option, tmp_path / "fifo") == 0
        assert reader.text().startswith(start)
    assert sorted(os.listdir(tmp_path)) == ["fifo", "it.bs2"]


def cgagen(*words: object) -> subprocess.CompletedProcess[bytes]:
    return subprocess.run(
        [sys.executable, "-m", "cgagen", *map(str, words)],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        check=True,
        timeout=120,
    )


def test_what_takes_stdout_has_it_alone(tmp_path: Path) -> None:
    source, image = tmp_path / "it.bs2", tmp_path / "it.bin"
    source.write_text(BLINK)
    done = cgagen("emulate", source, "--vcd", "/dev/stdout", "--for", "2s")
    assert done.stdout.startswith(b"$timescale")
    assert done.stdout.split()[-1].startswith(b"#")
    assert b"blink" not in done.stdout
    assert b"blink" in done.stderr
    told = cgagen("compile", source, "-o", image)
    done = cgagen("compile", source, "-o", "/dev/fd/1")
    assert (done.stdout, done.stderr) == (image.read_bytes(), told.stdout)
