"""Where the tokenizer's file comes from, and that none but the locked one is run."""

import json
from importlib import resources
from pathlib import Path

import pytest

from cgagen.cli import main
from cgagen.errors import ToolchainError
from cgagen.tokenizer.worker import Worker
from cgagen.toolchain import TOKENIZER_SHA256, find_tokenizer, setup, tokenizer_path
from tests.toolchain_cases import LED, REAL_NODE, REAL_TOKENIZER


def test_an_empty_cache_is_one_sentence_and_exit_4(
    empty_cache: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "led.bs2").write_text(LED)
    assert main(["compile", str(tmp_path / "led.bs2")]) == 4
    err = capsys.readouterr().err
    assert "run `cgagen setup` once" in err
    assert err.count("\n") == 1


def test_a_tampered_tokenizer_is_never_run(
    empty_cache: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mark = tmp_path / "was-run"
    evil = f"require('fs').writeFileSync({json.dumps(str(mark))}, 'x');\n".encode()
    tokenizer_path().parent.mkdir(parents=True)
    tokenizer_path().write_bytes(evil + REAL_TOKENIZER.read_bytes())
    with pytest.raises(ToolchainError, match=r"hash is .* was not run; run `cgagen setup`"):
        find_tokenizer()
    (tmp_path / "led.bs2").write_text(LED)
    assert main(["compile", str(tmp_path / "led.bs2")]) == 4
    worker = str(resources.files("cgagen.tokenizer") / "worker.cjs")
    with pytest.raises(ToolchainError, match="hash"):
        Worker([str(REAL_NODE), worker, str(tokenizer_path()), TOKENIZER_SHA256])
    assert not mark.exists()
    assert setup(REAL_TOKENIZER) == (tokenizer_path(), True)
    assert find_tokenizer() == tokenizer_path()


def test_one_flipped_bit_is_enough(empty_cache: Path) -> None:
    content = bytearray(REAL_TOKENIZER.read_bytes())
    content[500_000] ^= 1
    tokenizer_path().parent.mkdir(parents=True)
    tokenizer_path().write_bytes(content)
    with pytest.raises(ToolchainError, match="hash"):
        find_tokenizer()


def test_a_named_tokenizer_goes_before_the_cache(
    empty_cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CGAGEN_TOKENIZER", str(REAL_TOKENIZER))
    assert find_tokenizer() == REAL_TOKENIZER
    assert setup() == (REAL_TOKENIZER, False)  # so `make setup` works without a network
    for path, words in ((tmp_path / "none.js", "is not there"), (tmp_path, "is a folder")):
        monkeypatch.setenv("CGAGEN_TOKENIZER", str(path))
        for call in (find_tokenizer, setup):
            with pytest.raises(ToolchainError, match=words):
                call()


def test_a_relative_cache_is_ignored(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    for value in ("", "relative/cache"):
        monkeypatch.setenv("XDG_CACHE_HOME", value)
        assert tokenizer_path().is_relative_to(tmp_path / ".cache" / "cgagen")


@pytest.mark.parametrize("which", ["folder", "file"])
def test_a_tokenizer_that_others_can_write_is_not_run(empty_cache: Path, which: str) -> None:
    """What is run could be exchanged behind the look at its hash."""
    setup(REAL_TOKENIZER)
    found = find_tokenizer()
    (found if which == "file" else found.parent).chmod(0o777)
    with pytest.raises(ToolchainError, match=r"all users can write it.*cgagen setup"):
        find_tokenizer()
    setup(REAL_TOKENIZER)
    assert find_tokenizer() == found
