"""`cgagen flash`: what is refused before a port is opened."""

import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from cgagen import genome
from cgagen.cli import main
from cgagen.emulator.programs import bench_of_image
from cgagen.serve import serve
from tests.flash_cases import PREDATOR, blank


@pytest.fixture
def build(tmp_path: Path) -> Path:
    return Path(shutil.copytree(PREDATOR, tmp_path / "build"))


def refused(words: list[str], code: int, capsys: pytest.CaptureFixture[str]) -> str:
    assert main(["flash", *words, "--dry-run"]) == code
    return capsys.readouterr().err


def changed(path: Path, old: str, new: str) -> None:
    text = path.read_text("utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), "utf-8")


def test_a_truncated_image(build: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = build / "main.bin"
    path.write_bytes(path.read_bytes()[:2000])
    assert "main.bin: an EEPROM image of a BS2p has 2048" in refused([str(build)], 3, capsys)
    assert "this one has 2000" in refused([str(path)], 3, capsys)


def test_a_changed_image(build: Path, capsys: pytest.CaptureFixture[str]) -> None:
    data = bytearray((build / "main.bin").read_bytes())
    data[1500] ^= 1
    (build / "main.bin").write_bytes(data)
    assert "its digest is not the one in build.json" in refused([str(build)], 3, capsys)


def test_another_genome(build: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = (build / "best.genome").read_text("utf-8")
    bits = next(line for line in text.splitlines() if line.strip().startswith(("0", "1")))
    flipped = ("1" if bits.strip()[0] == "0" else "0") + bits.strip()[1:]
    changed(build / "best.genome", bits.strip(), flipped)
    assert "best.genome: its table has digest" in refused([str(build)], 3, capsys)


def test_a_genome_that_the_image_alone_does_not_have(
    build: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Both files say the same, and the image says something else."""
    old = genome.load(build / "best.genome")
    other = replace(old, bits=old.bits[::-1])
    (build / "best.genome").write_text(genome.to_text(other), "utf-8")
    changed(build / "build.json", old.digest, other.digest)
    err = refused([str(build)], 3, capsys)
    assert f"main.bin: says of itself that its genome is {old.digest[:8]}" in err


def test_an_edited_source(build: Path, capsys: pytest.CaptureFixture[str]) -> None:
    changed(build / "main.bsp", "PAUSE", "PAUSE ")
    assert "main.bsp: is not what the images were made from" in refused([str(build)], 3, capsys)


def test_an_image_for_another_model(build: Path, capsys: pytest.CaptureFixture[str]) -> None:
    err = refused([str(build / "main.bin"), "--model", "BS2"], 3, capsys)
    assert "main.bin: is for a BS2p, not for a BS2;" in err


def test_a_source_is_compiled_and_its_blocks_alone_are_sent(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "hello.bs2"
    path.write_text('\' {$STAMP BS2}\nDEBUG "hello", CR\nEND\n', "utf-8")
    bench = bench_of_image(blank("BS2"))
    with serve(bench, "rfc2217:0") as server:
        assert main(["flash", str(path), "--port", server.url]) == 0
    out = capsys.readouterr().out
    assert "hello: BS2 on rfc2217://" in out
    assert "has taken all 2 packets" in out
    assert "it talks" in out
    assert "is for a BS2, not for a BS2p;" in refused([str(path), "--model", "BS2P"], 3, capsys)
    path.write_text("' {$STAMP BS2}\nFLY\n", "utf-8")
    assert "hello.bs2" in refused([str(path)], 6, capsys)


def test_a_bare_image(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "x.bin"
    path.write_bytes(bytes(2048))
    assert "add --model with one of BS2, BS2e" in refused([str(path)], 2, capsys)
    assert main(["flash", str(path), "--model", "bs2pe", "--slot", "3", "--dry-run"]) == 0
    assert "slot byte 03h, 128 packets" in capsys.readouterr().out
    assert "a BS2 has no program slot 1" in refused(
        [str(path), "--model", "BS2", "--slot", "1"], 3, capsys
    )
    path.write_bytes(bytes(2049))
    assert "x.bin: an EEPROM image" in refused([str(path), "--model", "BS2"], 3, capsys)
    assert "cannot be read" in refused([str(tmp_path / "no.bin"), "--model", "BS2"], 3, capsys)


def test_verify_of_another_program_is_refused_before_anything_is_sent(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "x.bin"
    path.write_bytes(bytes(2048))
    assert main(["flash", str(path), "--model", "BS2", "--verify", "--port", "/dev/no"]) == 3
    assert "leave --verify out" in capsys.readouterr().err


def test_words_that_do_not_go_together(capsys: pytest.CaptureFixture[str]) -> None:
    for words in (
        [],
        ["--identify-only", str(PREDATOR)],
        [str(PREDATOR), "--model", "BS2"],
        [str(PREDATOR), "--port", "/dev/x"],
        [str(PREDATOR / "main.bin"), "--main", "/dev/x"],
    ):
        assert main(["flash", *words]) == 2, words
    assert main(["flash", str(PREDATOR), "--main", "/dev/x", "--locomotion", "/dev/x"]) == 7
    assert "cannot be both chips" in capsys.readouterr().err
