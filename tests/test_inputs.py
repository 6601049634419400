"""The one reader of users' files: what is no file, what is too large, what is no text."""

import gzip
import io
import os
import socket
import stat
import threading
from pathlib import Path

import pytest

from cgagen.errors import CgagenError, RobotError
from cgagen.inputs import (
    Kind,
    decoded,
    gunzipped,
    read_bytes,
    read_bytes_if_there,
    read_stream,
    read_text,
    start_of,
)

SMALL = Kind("a robot", 1_000, RobotError, "give a robot's TOML file")


def test_a_file_and_links_to_it_are_read(tmp_path: Path) -> None:
    file, link = tmp_path / "a.toml", tmp_path / "link"
    file.write_bytes(b"\xef\xbb\xbfname\n")
    link.symlink_to(file)
    assert read_bytes(link, SMALL) == b"\xef\xbb\xbfname\n"
    assert read_text(str(file), SMALL) == "name\n"


def _fifo(path: Path) -> None:
    os.mkfifo(path)


def _socket(path: Path) -> None:
    with socket.socket(socket.AF_UNIX) as one:
        one.bind(str(path))


def _device(path: Path) -> None:
    try:
        os.mknod(path, 0o600 | stat.S_IFCHR, os.makedev(1, 5))  # as /dev/zero
    except OSError as error:
        pytest.skip(f"no device may be made here ({error})")


def _loop(path: Path) -> None:
    path.symlink_to(path)


def _large(path: Path) -> None:
    with path.open("wb") as file:
        file.truncate(1 << 40)


def _fifo_behind_a_link(path: Path) -> None:
    os.mkfifo(path.with_name("pipe"))
    path.symlink_to(path.with_name("pipe"))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (_fifo, "is a pipe, not a robot; write its content to a file, and name that"),
        (_fifo_behind_a_link, "is a pipe, not a robot; write its content"),
        (_socket, "is a socket, not a robot"),
        (_device, "is a device, not a robot"),
        (Path.mkdir, "is a folder, not a robot; give a robot's TOML file"),
        (_loop, "cannot be read (Too many levels of symbolic links); give a robot's"),
        (_large, "1,099,511,627,776 bytes are too many for a robot (at most 1,000 bytes)"),
    ],
)
def test_what_is_no_file_of_a_sensible_size_is_refused(tmp_path, make, words) -> None:
    path = tmp_path / "thing.toml"
    make(path)
    with pytest.raises(RobotError) as refused:
        read_bytes(path, SMALL)
    assert str(refused.value).startswith(f"{path}: {words}")
    assert start_of(path, 10) is None or make is _large


def test_a_port_is_not_even_opened(tmp_path, monkeypatch) -> None:
    """Opening one raises DTR, which resets a Stamp."""
    opened: list[object] = []
    monkeypatch.setattr(os, "open", lambda *words: opened.append(words) or 1 / 0)
    _fifo(tmp_path / "port")
    with pytest.raises(RobotError, match="is a pipe"):
        read_bytes(tmp_path / "port", SMALL)
    assert not opened


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("nul\0.toml", "cannot be read \\(no file can have such a name\\)"),
        ("n" * 300, "cannot be read \\(File name too long\\)"),
        ("missing", "cannot be read \\(No such file or directory\\)"),
        ("\x1b[31m", r"/\\x1b\[31m: cannot be read"),
        ("\udcff.toml", r"\\udcff.toml: cannot be read"),
    ],
)
def test_names_that_no_file_has(tmp_path, name, words) -> None:
    with pytest.raises(RobotError, match=words) as refused:
        read_bytes(tmp_path / name, SMALL)
    assert len(str(refused.value)) < 500
    if name == "nul\0.toml":
        return
    if name != "n" * 300:
        assert read_bytes_if_there(tmp_path / name, SMALL) is None


def test_a_file_without_permission(tmp_path, monkeypatch) -> None:
    file = tmp_path / "a"
    file.write_text("x")

    def refuse(*_words: object) -> int:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(os, "open", refuse)
    with pytest.raises(RobotError, match=r"cannot be read \(Permission denied\)"):
        read_bytes(file, SMALL)


def test_a_stream_is_read_up_to_its_limit() -> None:
    assert read_stream(io.BytesIO(b"x" * 1_000), "-", SMALL) == b"x" * 1_000
    with pytest.raises(RobotError, match="-: its content is too many for a robot"):
        read_stream(io.BytesIO(b"x" * 1_001), "-", SMALL)


def test_what_a_writer_never_ends_is_ended_by_the_limit() -> None:
    reader, writer = os.pipe()

    def write() -> None:
        try:
            while True:
                os.write(writer, bytes(65_536))
        except OSError:
            os.close(writer)

    thread = threading.Thread(target=write)
    thread.start()
    with os.fdopen(reader, "rb") as file, pytest.raises(RobotError, match="too many"):
        read_stream(file, "typed", SMALL)
    thread.join(10)
    assert not thread.is_alive()


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"a\nb\xffc", "line 2: not UTF-8 at byte 3; save it as UTF-8"),
        ("name".encode("utf-16"), "is text of 16 bits a character"),
        ("name".encode("utf-16-be"), None),
    ],
)
def test_what_is_no_utf_8(data, words) -> None:
    if words is None:
        assert decoded(data, "a", SMALL) == "\0n\0a\0m\0e"
        return
    with pytest.raises(RobotError, match=words):
        decoded(data, "a.toml", SMALL)


def test_packed_files_unpack_to_no_more_than_their_kind_may_have() -> None:
    assert gunzipped(gzip.compress(b"x" * 1_000), "a.gz", SMALL) == b"x" * 1_000
    members = gzip.compress(b"one ") + gzip.compress(b"two") + bytes(512)
    assert gunzipped(members, "a.gz", SMALL) == b"one two"
    bomb = gzip.compress(bytes(50_000_000))
    assert len(bomb) < 60_000
    for packed in (bomb, gzip.compress(b"x" * 600) * 2):
        with pytest.raises(CgagenError, match="unpacks to more than 1,000 bytes"):
            gunzipped(packed, "a.gz", SMALL)
    with pytest.raises(RobotError, match="is cut"):
        gunzipped(gzip.compress(b"x" * 900)[:-9], "a.gz", SMALL)
    with pytest.raises(RobotError, match="cannot be unpacked"):
        gunzipped(b"no gzip", "a.gz", SMALL)
