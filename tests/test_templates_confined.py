"""Templates of others: they run nothing, read nothing else, come to an end, and are located."""

import os
from pathlib import Path

import pytest

from cgagen.build import make_build
from cgagen.cli import main
from cgagen.errors import SourceError, TemplateError
from cgagen.firmware import confined, generate
from cgagen.firmware.render import CHECKOUT, Renderer
from tests.firmware_cases import GENOME, robot_of
from tests.subjects import FIRMWARE

PREDATOR = robot_of("predator")
NAME = "predator-main.bsp.j2"


def refused(folder: Path, text: str, name: str = NAME) -> str:
    (folder / name).write_text(text, "utf-8")
    with pytest.raises(TemplateError) as caught:
        generate(PREDATOR, GENOME, folder)
    sentence = str(caught.value)
    assert "\n" not in sentence
    assert len(sentence) < 2_000
    return sentence


@pytest.mark.parametrize(
    "text",
    [
        '{{ cycler.__init__.__globals__.os.popen("touch armed").read() }}',
        "{{ lipsum.__globals__['os'].system('touch armed') }}",
        "{{ ''.__class__.__mro__[1].__subclasses__() }}",
        "{{ ''['__class__'] }}",
        "{{ ''|attr('__class__') }}",
        "{{ '{0.__class__.__init__.__globals__}'.format(role) }}",
        "{{ '%s'|format(self.__init__.__globals__) }}",
        "{{ self._TemplateReference__context.environment.loader }}",
        "{{ [1].append(2) }}",
        "{{ pins.append(2) }}",
        "{% set x = namespace() %}{{ x.__init__.__globals__ }}",
        "{{ ['__class__']|map('attr', '__class__')|list }}{{ x }}",
    ],
)
def test_no_template_gets_behind_what_it_is_given(tmp_path: Path, text: str, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    sentence = refused(tmp_path, f"' line 1\n{text}\n")
    assert f"{NAME}:2: " in sentence
    assert not (tmp_path / "armed").exists()


@pytest.mark.parametrize(
    "name", ["../secret.txt", "/etc/hostname", "a/../../secret.txt", "..\\secret.txt", "a\0b"]
)
@pytest.mark.parametrize("how", ["include", "import", "extends"])
def test_no_template_comes_from_elsewhere(tmp_path: Path, name: str, how: str) -> None:
    folder = tmp_path / "mine"
    folder.mkdir()
    (tmp_path / "secret.txt").write_text("secret")
    escaped = name.replace("\\", "\\\\").replace("\0", "\\0")
    after = " as x" if how == "import" else ""
    sentence = refused(folder, f'{{% {how} "{escaped}"{after} %}}\n')
    assert "leads out of its folder" in sentence or "wants the template" in sentence


def test_a_link_out_of_the_folder_is_refused(tmp_path: Path) -> None:
    folder = tmp_path / "mine"
    folder.mkdir()
    (tmp_path / "secret.txt").write_text("secret")
    (folder / "_telemetry.j2").symlink_to(tmp_path / "secret.txt")
    with pytest.raises(TemplateError, match="is a link that leads out of the folder"):
        generate(PREDATOR, GENOME, folder)


def test_a_pipe_for_a_template_is_refused(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "_telemetry.j2")
    with pytest.raises(TemplateError, match="is a pipe, not a template"):
        generate(PREDATOR, GENOME, tmp_path)


@pytest.mark.parametrize(
    "text",
    [
        "{% for a in range(99999) %}{% for b in range(99999) %}{% endfor %}{% endfor %}",
        "{{ 'x' * 10**10 }}",
        "{{ 10**(10**10) }}",
        "{{ ('x' * 10**8)|list|length }}",
        "{{ 'x'|center(10**10) }}",
        "{{ '%9999999999d'|format(1) }}",
        "{{ range(10**9)|list }}",
        "{% for a in range(9999) %}{{ 'x' * 9999 }}{% endfor %}",
        "{% macro again() %}{{ again() }}{% endmacro %}{{ again() }}",
        f"{{% include '{NAME}' %}}",
    ],
)
def test_every_template_comes_to_an_end(tmp_path: Path, text: str, monkeypatch) -> None:
    monkeypatch.setattr(confined, "LIMIT_S", 3)
    assert NAME in refused(tmp_path, text)


def test_the_process_of_a_template_can_write_nothing_of_note(tmp_path: Path) -> None:
    """Its limits are set before anything is filled in."""
    folders = [CHECKOUT]
    made = confined.render_confined(folders, "_pin_table.j2", {"pin_table": [], "pins": []})
    assert made.digests.keys() == {"_pin_table.j2"}


def test_own_templates_give_what_ours_give(tmp_path: Path) -> None:
    """The other process changes nothing, and no mark is left."""
    for path in CHECKOUT.glob("*.j2"):
        (tmp_path / path.name).write_bytes(path.read_bytes())
    ours, theirs = generate(PREDATOR, GENOME), generate(PREDATOR, GENOME, tmp_path)
    assert theirs.files == ours.files
    assert theirs.templates == ours.templates
    assert theirs.notes == ()
    assert "\x02" not in "".join(ours.files.values())


def test_each_line_knows_the_template_that_made_it() -> None:
    for program in generate(PREDATOR, GENOME).programs:
        lines = program.source.splitlines()
        assert len(program.origins) == len(lines)
        same = 0
        for line, (file, number) in zip(lines, program.origins, strict=True):
            if not line or not file:
                continue
            written = Path(file).read_text("utf-8").splitlines()[number - 1]
            if "{{" not in written:
                assert written.rstrip() == line, (file, number)
                same += 1
        assert same > 150


def test_names_that_nothing_asks_for_are_told(tmp_path: Path) -> None:
    (tmp_path / "_telemetri.j2").write_text("'")
    firmware = generate(PREDATOR, GENOME, tmp_path)
    first, second = firmware.notes
    assert "_telemetri.j2: no template of that name is used (did you mean _telemetry.j2?)" in first
    assert "there are _bench_dump.j2, " in first
    assert "replaces no template of this robot's" in second
    (tmp_path / "_telemetry.j2").write_text("Report:\n  RETURN\n")
    assert len(generate(PREDATOR, GENOME, tmp_path).notes) == 1
    (tmp_path / "_telemetri.j2").rename(tmp_path / "prey-main.bsp.j2")
    assert generate(PREDATOR, GENOME, tmp_path).notes == ()


def test_the_verb_tells_them(tmp_path: Path, capsys) -> None:
    (tmp_path / "mine").mkdir()
    words = ["build", str(FIRMWARE / "reference.genome"), "-o", str(tmp_path / "out")]
    assert main([*words, "--templates", str(tmp_path / "mine")]) == 0
    assert "mine: replaces no template of this robot's" in capsys.readouterr().err


def test_a_program_that_is_refused_is_located_and_left(tmp_path: Path, tokenizer, monkeypatch):
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    folder = tmp_path / "mine"
    folder.mkdir()
    text = (CHECKOUT / "_telemetry.j2").read_text("utf-8")
    (folder / "_telemetry.j2").write_text(f"{text}  DEBUG DEC nowhere\n", "utf-8")
    place = f"{folder / '_telemetry.j2'}:{len(text.splitlines()) + 1}"
    with pytest.raises(SourceError) as refused:
        make_build(PREDATOR, GENOME, tokenizer, folder)
    told = str(refused.value)
    assert f"comes from {place}, and the text is left in {tmp_path}" in told
    left = Path(told.rpartition("left in ")[2])
    assert left.name == "main.bsp"
    assert refused.value.line is not None
    assert left.read_text().splitlines()[refused.value.line - 1] == "  DEBUG DEC nowhere"


def test_a_folder_of_many_files_is_looked_at_in_part(tmp_path: Path) -> None:
    for number in range(1_200):
        (tmp_path / f"{number}.txt").touch()
    first, *_, more, nothing = notes = Renderer(tmp_path).notes()
    assert len(notes) == 12
    assert "no template of that name is used" in first
    assert more.endswith("990 more files likewise")
    assert "replaces no template" in nothing


def test_nothing_of_the_folder_that_one_works_in_is_run(tmp_path: Path, monkeypatch) -> None:
    for name in ("json", "pickle", "jinja2", "cgagen"):
        (tmp_path / f"{name}.py").write_text("import pathlib; pathlib.Path('armed').touch()\n")
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "_telemetry.j2").write_bytes((CHECKOUT / "_telemetry.j2").read_bytes())
    monkeypatch.chdir(tmp_path)
    assert generate(PREDATOR, GENOME, tmp_path / "mine").files == generate(PREDATOR, GENOME).files
    assert not (tmp_path / "armed").exists()


@pytest.mark.parametrize("numbers", ["99999:1", "9" * 5_000 + ":1", "0:" + "9" * 5_000])
def test_a_templates_own_text_may_look_like_a_mark(tmp_path: Path, numbers: str) -> None:
    (tmp_path / "_telemetry.j2").write_text(f"{{{{ '\\x02{numbers}\\x03' }}}}'\n", "utf-8")
    assert generate(PREDATOR, GENOME, tmp_path).programs
