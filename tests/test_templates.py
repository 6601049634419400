"""Templates of a user's own, and what is said when they are wrong."""

import re
from pathlib import Path

import pytest

from cgagen.errors import TemplateError
from cgagen.firmware import generate
from cgagen.firmware.render import CHECKOUT, Renderer, shipped_templates
from tests.firmware_cases import GENOME, robot_of

PREDATOR = robot_of("predator")
MAIN = (CHECKOUT / "predator-main.bsp.j2").read_text("utf-8")


def refused(folder: Path, name: str, text: str) -> str:
    (folder / name).write_text(text, "utf-8")
    with pytest.raises(TemplateError) as caught:
        generate(PREDATOR, GENOME, folder)
    sentence = str(caught.value)
    assert "\n" not in sentence
    assert name in sentence
    return sentence


def test_ours_are_found() -> None:
    assert shipped_templates() == CHECKOUT


def test_ours_are_strict_and_do_no_arithmetic() -> None:
    for path in CHECKOUT.glob("*.j2"):
        text = path.read_text("ascii")
        for tag in re.findall(r"{[{%](.*?)[}%]}", text):
            assert not re.search(r"[-+*/|~]|\[|\bset\b", tag.replace('"_', "")), (path.name, tag)


def test_every_file_in_the_folder_is_used() -> None:
    used = set()
    for case in ("predator", "predator-free-running", "prey"):
        genome = GENOME if case.startswith("predator") else None
        used |= {name for name, _ in generate(robot_of(case), genome).templates}
    assert used == {path.name for path in CHECKOUT.glob("*.j2")}


def test_a_users_template_comes_first_and_the_rest_stays_ours(tmp_path: Path) -> None:
    (tmp_path / "_telemetry.j2").write_text("Report:\n  ' nothing to report\n  RETURN\n")
    ours, theirs = generate(PREDATOR, GENOME), generate(PREDATOR, GENOME, tmp_path)
    assert "nothing to report" in theirs.files["main.bsp"]
    assert "DEC echo(Front)" not in theirs.files["main.bsp"]
    assert theirs.files["locomotion.bs2"] == ours.files["locomotion.bs2"]
    assert dict(theirs.templates).keys() == dict(ours.templates).keys()
    differing = {name for name, digest in theirs.templates if dict(ours.templates)[name] != digest}
    assert differing == {"_telemetry.j2"}


def test_line_ends_of_another_system_change_nothing(tmp_path: Path) -> None:
    text = MAIN.replace("\n", "\r\n").encode()
    (tmp_path / "predator-main.bsp.j2").write_bytes(text)
    assert generate(PREDATOR, GENOME, tmp_path) == generate(PREDATOR, GENOME)


def test_an_unknown_word_is_named_with_its_line(tmp_path: Path) -> None:
    lines = MAIN.splitlines()
    lines[9] = "' {{ colour }}"
    sentence = refused(tmp_path, "predator-main.bsp.j2", "\n".join(lines))
    assert "predator-main.bsp.j2:10: 'colour' is undefined; the words of" in sentence
    assert "robot_name" in sentence


def test_an_unknown_word_in_an_included_template_is_named_there(tmp_path: Path) -> None:
    sentence = refused(tmp_path, "_telemetry.j2", "' one\n' {{ telemetry.speed }}\n")
    assert "_telemetry.j2:2: 'bool object' has no attribute 'speed'" in sentence


def test_broken_jinja_is_named_with_its_line(tmp_path: Path) -> None:
    sentence = refused(tmp_path, "_sense.j2", "' one\n' two\n{% if telemetry %}\n' three\n")
    assert re.search(r"_sense\.j2:\d: Unexpected end of template", sentence)
    assert sentence.endswith("mend the template's Jinja")


def test_an_expression_that_fails_is_named_with_its_line(tmp_path: Path) -> None:
    assert "_sense.j2:1: " in refused(tmp_path, "_sense.j2", "{{ 1 // 0 }}\n")


def test_a_template_that_is_nowhere_is_named(tmp_path: Path) -> None:
    sentence = refused(tmp_path, "_sense.j2", '{% include "_other.j2" %}\n')
    assert "wants the template _other.j2" in sentence


def test_a_circle_of_includes_is_named(tmp_path: Path) -> None:
    refused(tmp_path, "predator-main.bsp.j2", '{% include "predator-main.bsp.j2" %}\n')


def test_a_program_that_is_not_ascii_is_refused(tmp_path: Path) -> None:
    sentence = refused(tmp_path, "predator-main.bsp.j2", MAIN + "\n' K\u00e4fer\n")
    assert re.search(r"line \d+ of the program has '\u00e4' in it", sentence)


def test_a_template_that_is_not_text_is_refused(tmp_path: Path) -> None:
    (tmp_path / "predator-main.bsp.j2").write_bytes(b"' K\xe4fer\n")
    with pytest.raises(TemplateError, match=r"predator-main\.bsp\.j2: line 1: not UTF-8 at byte 3"):
        generate(PREDATOR, GENOME, tmp_path)


def test_a_folder_that_is_none_is_refused(tmp_path: Path) -> None:
    with pytest.raises(TemplateError, match=r"nowhere: no such folder"):
        Renderer(tmp_path / "nowhere")
