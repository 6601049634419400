"""A small sample of `make kills`: verbs that are stopped or killed leave nothing half done."""

from pathlib import Path

from tests.kill_verbs import VERBS, is_temporary_path, is_whole, kills

QUICK = tuple(verb for verb in VERBS if not verb.slow and verb.name not in ("build", "convert"))


def test_a_sample_of_kills() -> None:
    done, wrong = kills(len(QUICK), seed=20, verbs=QUICK)
    assert wrong == []
    assert done.total() == len(QUICK) == 6


def test_what_is_half_is_seen() -> None:
    compiled = next(verb for verb in VERBS if verb.name == "compile")
    emulated = next(verb for verb in VERBS if verb.name == "emulate")
    whole = {"it.bin": b"12345678", "it.vcd": b"#1\n0!\n#2\n1!\n"}
    assert is_whole(compiled, "it.bin", b"12345678", whole)
    assert not is_whole(compiled, "it.bin", b"1234", whole)
    assert not is_whole(compiled, "other", b"", whole)
    assert is_whole(emulated, "it.vcd", b"#1\n0!\n", whole)
    assert not is_whole(emulated, "it.vcd", b"#1\n0", whole)
    assert not is_whole(emulated, "it.vcd", b"#3\n0!\n#4\n", whole)
    assert is_temporary_path(str(Path(".cgagen-0123abcd.tmp") / "main.bsp"))
