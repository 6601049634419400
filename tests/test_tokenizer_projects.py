"""Projects of several sources: names ignore case, a backslash parts folders; what lies outside."""

from pathlib import Path

import pytest

from cgagen.cli import main
from cgagen.errors import SourceError
from cgagen.tokenizer import Tokenizer
from cgagen.tokenizer.files import read_source
from cgagen.tokenizer.project import ProjectSources, found_in

ROOT = Path(__file__).parent.parent
SECOND = '\' {$STAMP BS2p}\nDEBUG "b"\nEND\n'


def first(names: str) -> str:
    return f'\' {{$STAMP BS2p, {names}}}\nDEBUG "a"\nRUN 1\n'


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A folder with a source, and others beside it, below it and outside."""
    folder = tmp_path / "project"
    (folder / "Sub").mkdir(parents=True)
    for place in ("nextone.bsp", "Sub/other.bsp", "two words.bsp", "../outside.bsp"):
        (folder / place).write_text(SECOND)
    return folder


@pytest.mark.parametrize(
    "name",
    [
        "nextone.bsp",
        "NEXTONE.BSP",
        "NextOne.bsp",
        ".\\nextone.BSP",
        "sub\\other.bsp",
        "SUB\\OTHER.BSP",
        "Sub/other.bsp",
        '"Two Words.bsp"',
    ],
)
@pytest.mark.parametrize("how", ["source", "bench", "flash"])
def test_a_further_file_is_found_as_windows_finds_it(
    project: Path, name: str, how: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (project / "a.bsp").write_text(first(name))
    (project / "bench.toml").write_text(
        'format = "cgagen-bench-1"\n[chip.main]\nsource = "a.bsp"\n'
    )
    if how == "flash":
        assert main(["flash", str(project / "a.bsp"), "--dry-run"]) == 0
        assert "slot byte 01h" in capsys.readouterr().out
        return
    file = project / ("a.bsp" if how == "source" else "bench.toml")
    assert main(["emulate", str(file), "--for", "1s"]) == 0
    said = capsys.readouterr()
    assert said.out == "ab"
    assert "outside" not in said.err


def test_two_files_that_differ_in_case_alone_are_told_apart(project: Path) -> None:
    (project / "NEXTONE.BSP").write_text(SECOND)
    source = project / "a.bsp"
    assert found_in(source, "nextone.bsp") == project / "nextone.bsp"
    assert found_in(source, "NEXTONE.BSP") == project / "NEXTONE.BSP"
    with pytest.raises(SourceError, match=r"a\.bsp: .* has NEXTONE\.BSP and nextone\.bsp; write"):
        found_in(source, "NextOne.bsp")


@pytest.mark.parametrize("name", ["..\\outside.bsp", "../OUTSIDE.bsp", "Sub\\..\\..\\outside.bsp"])
def test_a_file_outside_the_project_is_told(
    project: Path, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (project / "a.bsp").write_text(first(name))
    assert main(["emulate", str(project / "a.bsp"), "--for", "1s"]) == 0
    said = capsys.readouterr()
    assert said.out == "ab"
    assert f"names {name}, which is {project.parent.resolve() / 'outside.bsp'}, outside" in said.err


def test_a_link_that_leads_outside_is_told(
    project: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (project / "link.bsp").symlink_to(project.parent / "outside.bsp")
    (project / "a.bsp").write_text(first("link.bsp"))
    assert main(["emulate", str(project / "a.bsp"), "--for", "1s"]) == 0
    assert "outside the project's folder" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("missing.bsp", "has no missing.bsp; put it there"),
        ("gone\\other.bsp", "has no gone; put it there"),
        ("C:\\stamps\\x.bsp", "a place of another computer"),
        ("/nowhere-at-all/x.bsp", "/ has no nowhere-at-all"),
    ],
)
def test_what_is_not_there_is_said_with_who_names_it(
    project: Path, name: str, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (project / "a.bsp").write_text(first(name))
    assert main(["emulate", str(project / "a.bsp"), "--for", "1s"]) == 6
    said = capsys.readouterr().err
    assert f"a.bsp: its $STAMP line names {name}" in said
    assert words in said


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "utf-16-be"])
def test_utf16_is_named(tmp_path: Path, encoding: str) -> None:
    file = tmp_path / "a.bs2"
    file.write_bytes("' {$STAMP BS2} \u4e09\r\nHIGH 1\r\n".encode(encoding))
    with pytest.raises(SourceError, match="UTF-16"):
        read_source(file)


@pytest.mark.parametrize("text", ["", "\0", "a\0", "' {$STAMP BS2}\n"])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "cp1252"])
def test_other_texts_are_not_taken_for_utf16(tmp_path: Path, text: str, encoding: str) -> None:
    file = tmp_path / "a.bs2"
    file.write_bytes(text.encode(encoding))
    assert read_source(file) == text


def test_a_warning_is_printed_with_its_place(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "a.bs2"
    file.write_text("' {$STAMP BS2}\nw VAR Word\nw = $4241\nDEBUG STR w\\2\nEND\n\x1a")
    for verb in (["emulate", str(file)], ["compile", str(file)], ["flash", str(file), "--dry-run"]):
        assert main(verb) == 0
        said = capsys.readouterr().err
        assert f"{file}:4:11: warning: STR w names a word" in said
        assert f"{file}:6:1: warning: Ctrl-Z is taken for a blank" in said
        assert main(["-q", *verb]) == 0
        assert capsys.readouterr().err == ""


def test_a_twin_of_the_file_that_is_read_is_told(
    project: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (project / "NextOne.bsp").write_text(SECOND.replace('"b"', '"other"'))
    (project / "a.bsp").write_text(first("nextone.bsp"))
    assert main(["emulate", str(project / "a.bsp"), "--for", "1s"]) == 0
    said = capsys.readouterr()
    assert said.out == "ab"
    assert "has NextOne.bsp, too, which Windows would take for the same: nextone.bsp is" in said.err


def test_a_name_of_a_further_file_s_own_stays_its_own(project: Path) -> None:
    """`x.bsp` of the first source is not the one beside a further source that names one, too."""
    (project / "Sub" / "x.bsp").write_text(SECOND.replace('"b"', '"wrong"'))
    (project / "x.bsp").write_text(SECOND.replace('"b"', '"x"'))
    (project / "Sub" / "other.bsp").write_text(SECOND.replace("BS2p", "BS2p, x.bsp"))
    (project / "a.bsp").write_text(first("sub\\other.bsp, x.bsp"))
    with Tokenizer() as tokenizer:
        found = ProjectSources(tokenizer, pytest.fail).compile_all(project / "a.bsp")
    assert [Path(one.name).relative_to(project).as_posix() for one in found] == [
        "a.bsp",
        "Sub/other.bsp",
        "x.bsp",
    ]


@pytest.mark.parametrize("name", ["A.BSP", "../PROJECT/a.bsp", "..\\project\\A.bsp", ".\\a.bsp"])
def test_a_bench_names_its_files_so_too(
    project: Path, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (project / "a.bsp").write_text(first("sub\\OTHER.bsp"))
    bench = project / "bench.toml"
    bench.write_text(f"format = \"cgagen-bench-1\"\n[chip.main]\nsource = '{name}'\n")
    assert main(["emulate", str(bench), "--for", "1s"]) == 0
    assert capsys.readouterr().out == "ab"
    assert main(["compile", str(project / "nextone.bsp"), "-o", str(project / "Sub/b.bin")]) == 0
    bench.write_text(
        'format = "cgagen-bench-1"\n[chip.main]\nmodel = "BS2p"\nimage = \'SUB\\B.BIN\'\n'
    )
    capsys.readouterr()
    assert main(["emulate", str(bench), "--for", "1s"]) == 0
    assert capsys.readouterr().out == "b"


def test_one_program_in_two_slots(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (project / "a.bsp").write_text(first("nextone.bsp, nextone.bsp"))
    assert main(["flash", str(project / "a.bsp"), "--dry-run"]) == 0
    out = capsys.readouterr().out
    assert "slot byte 01h" in out
    assert "slot byte 02h" in out


def test_a_build_has_no_further_slots(
    project: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    templates = tmp_path / "templates"
    templates.mkdir()
    ours = (ROOT / "templates" / "_identity.j2").read_text()
    more = ours.replace("{$STAMP {{ stamp }}}", "{$STAMP {{ stamp }}, more.bsp}")
    assert more != ours
    (templates / "_identity.j2").write_text(more)
    words = ["build", "--robot", "servobot-prey", "-o", str(tmp_path / "b")]
    assert main([*words, "--templates", str(templates)]) == 6
    assert "names more.bsp, and a build has one program for each chip" in capsys.readouterr().err
    assert not (tmp_path / "b").exists()
