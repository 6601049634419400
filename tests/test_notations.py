"""TOML and JSON: what would take long, or is no error of Python's readers."""

import time

import pytest

from cgagen.notations import DEEPEST, parse_json, parse_toml


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("a = " + "1" * 5_000, "a whole number of thousands of digits"),
        ("a = " + "1" * 4_000, "a whole number of more than 64 bits"),
        ("a = " + "[" * 5_000, f"nested more than {DEEPEST} deep"),
        ("a = " + "{a=" * 5_000, f"nested more than {DEEPEST} deep"),
        ("a = " + "[" * 100 + "]" * 100, f"nested more than {DEEPEST} deep"),
        ("a." * 30_000 + "a = 1", f"line 1 has a key of more than {DEEPEST} parts"),
        ("b=1\n[" + '"a" . ' * 30_000 + "a]", f"line 2 has a key of more than {DEEPEST} parts"),
        ("x = { " + "'a'." * 30_000 + "a = 1 }", f"line 1 has a key of more than {DEEPEST}"),
        ("a = ", "Invalid value"),
        ("a = 1\na = 2", "Cannot overwrite"),
    ],
)
def test_toml_that_is_refused(text: str, words: str) -> None:
    began = time.monotonic()
    with pytest.raises(ValueError, match=words) as refused:
        parse_toml(text)
    assert type(refused.value) is ValueError
    assert len(str(refused.value)) < 300
    assert time.monotonic() - began < 5


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("1" * 5_000, "a whole number of thousands of digits"),
        ("1" * 4_000, "a whole number of more than 64 bits"),
        ("[" * 5_000, f"nested more than {DEEPEST} deep"),
        ('{"a":' * 100 + "1" + "}" * 100, f"nested more than {DEEPEST} deep"),
        ('{"a": 1, "b": 2, "a": 3}', "the key 'a' is there twice"),
        ("[NaN]", "NaN is no number"),
        ("-Infinity", "-Infinity is no number"),
        ("1e999", "1e999 is too large a number"),
        (r'{"\ud800": 1}', r"'\\ud800' is no text"),
        (b'{"a": "\xff"}', "byte 7 is not UTF-8 text"),
        ("{", "line 1: Expecting"),
    ],
)
def test_json_that_is_refused(text: str | bytes, words: str) -> None:
    with pytest.raises(ValueError, match=words) as refused:
        parse_json(text)
    assert type(refused.value) is ValueError
    assert len(str(refused.value)) < 300


def test_what_is_right_is_read() -> None:
    assert parse_toml(f"seed = {2**64 - 1}\n[a.b]\nc = [[1.5, 2], []]") == {
        "seed": 2**64 - 1,
        "a": {"b": {"c": [[1.5, 2], []]}},
    }
    assert parse_json('{"a": [1, -2.5, null, true, "\\u00e9"]}') == {
        "a": [1, -2.5, None, True, "é"]
    }
