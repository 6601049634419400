"""The build folder: what is in it, that it repeats, and that it is whole or not there."""

import json
import os
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

from cgagen import cli
from cgagen.build import FILES, Build, make_build, read_image, read_record, write_build
from cgagen.build.bench import bench_text
from cgagen.build.wiring import wiring_text
from cgagen.errors import BudgetError, FolderError, GenomeError, SourceError, StorageError
from cgagen.files import digest
from cgagen.genome import Genome, load, to_text
from cgagen.robot import load_robot
from cgagen.robot.reader import parse_robot
from cgagen.tokenizer import Tokenizer
from tests.firmware_cases import CASES, GENOME, genome_of, robot_of

ROOT = Path(__file__).parent.parent
PREDATOR = load_robot("servobot-predator")
TABLE = Genome(GENOME.bits, PREDATOR.name, PREDATOR.interface)


@pytest.fixture(scope="module")
def build(tokenizer: Tokenizer) -> Build:
    return make_build(PREDATOR, TABLE, tokenizer)


@pytest.fixture(scope="module")
def genome_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("genome") / "best.genome"
    path.write_text(to_text(TABLE))
    return path


def listing(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_the_folder_holds_all_that_it_was_made_of(tmp_path: Path, build: Build) -> None:
    folder = tmp_path / "out"
    write_build(folder, build.files())
    assert {path.name for path in folder.iterdir()} == FILES
    assert (folder / "robot.toml").read_text("utf-8") == PREDATOR.text
    assert load(folder / "best.genome") == TABLE
    record = read_record(folder)
    assert record["robot"]["digest"] == digest((folder / "robot.toml").read_bytes())
    assert record["genome"]["digest"] == TABLE.digest
    for name, wanted in record["files"].items():
        assert digest((folder / name).read_bytes()) == wanted
    assert record["files"].keys() | {"build.json"} == FILES
    for chip, suffix in (("main", "bsp"), ("locomotion", "bs2")):
        entry = record["programs"][chip]
        assert len((folder / entry["image"]).read_bytes()) == 2048
        assert entry["source"] == f"{chip}.{suffix}"
        assert entry["source_digest"] in (folder / entry["source"]).read_text("ascii")
        assert len(entry["blocks"]) == 128
    assert (record["programs"]["main"]["model"], record["programs"]["main"]["slot"]) == ("BS2p", 0)


def test_an_image_comes_back_with_its_flags(tmp_path: Path, build: Build) -> None:
    write_build(tmp_path / "out", build.files())
    for built in build.programs:
        assert read_image(tmp_path / "out", built.program.chip) == built.image


def test_a_changed_image_is_noticed(tmp_path: Path, build: Build) -> None:
    write_build(tmp_path / "out", build.files())
    path = tmp_path / "out" / "main.bin"
    path.write_bytes(b"\x01" + path.read_bytes()[1:])
    with pytest.raises(FolderError, match=r"main\.bin: its digest is not the one in build\.json"):
        read_image(tmp_path / "out", "main")


def test_the_same_inputs_give_the_same_bytes(tmp_path: Path, build: Build) -> None:
    with Tokenizer() as other:
        again = make_build(PREDATOR, TABLE, other)
    assert again.files() == build.files()
    for name, content in build.files().items():
        if not name.endswith(".bin"):
            assert str(ROOT).encode() not in content
            assert b"/tmp" not in content
    write_build(tmp_path / "a", build.files())
    write_build(tmp_path / "a", build.files())
    assert listing(tmp_path / "a") == build.files()
    assert [path.name for path in tmp_path.iterdir()] == ["a"]


@pytest.mark.parametrize("case", ["prey", "predator-srf04", "predator-free-running"])
def test_the_wiring_names_every_pin_and_part(case: str) -> None:
    robot = robot_of(case)
    text = wiring_text(robot)
    assert max(map(len, text.splitlines())) <= 100
    main, locomotion = text.split("Locomotion controller, ")
    data = tomllib.loads(CASES[case])
    for sonar in data["sonar"]:
        for key in ("pin", "trigger_pin", "echo_pin"):
            if key in sonar:
                assert f"  P{sonar[key]} " in main
    for pins in data["servo"]["pin"].values():
        assert all(f"  P{pin} " in locomotion for pin in pins)
    assert main.count("470 ohm in series\n") == (3 if case == "predator-free-running" else 4)
    assert locomotion.count("10 kohm to ground\n") == 3 + 12
    for words in ("analogue", "for at least 7.5 A", "from the board's own 5 V regulator"):
        assert words in " ".join(locomotion.split())
    assert ("10 kohm to +5 V\n" in locomotion) == (case != "predator-free-running")
    assert "220 ohm, 10 kohm to +5 V" in main
    for words in ("One ground for both", "supply of their own"):
        assert words in locomotion


@pytest.mark.parametrize(
    ("case", "grounded"),
    [("predator", []), ("predator-srf04", []), ("predator-srf04-bs2", ["front", "right", "left"])],
)
def test_the_wiring_names_the_sonars_whose_mode_pin_is_grounded(
    case: str, grounded: list[str]
) -> None:
    """S8 p. 6: a BS2 may miss the beginning of the echo, and the mode pin puts that off."""
    robot = robot_of(case)
    text = wiring_text(robot)
    assert ("SRF04 front, right, left: the fifth pin" in text) == bool(grounded)
    parts = tomllib.loads(bench_text(robot))["part"]
    made = [one.name for one in robot.sonars if parts[f"sonar_{one.name}"].get("mode_grounded")]
    assert made == grounded


def test_an_old_srf04_has_its_mode_pin_open_and_the_wiring_says_what_that_means() -> None:
    kind = 'kind = "srf04"'
    text = CASES["predator-srf04-bs2"].replace(kind, f'{kind}\nmode = "open"', 1)
    assert "on low" not in wiring_text(robot_of("predator-srf04-bs2"))
    robot = parse_robot(text, "old.toml")
    note = " ".join(wiring_text(robot).split())
    assert "SRF04 right, left: the fifth pin" in note
    assert "with its mode pin open on a BS2 is only just in time, on low pins (S8)" in note


def test_a_genome_for_other_sensors_is_refused(tokenizer: Tokenizer) -> None:
    other = Genome(GENOME.bits, "crab", PREDATOR.interface.replace("sonar front", "sonar up"))
    with pytest.raises(GenomeError, match="made for crab"):
        make_build(PREDATOR, other, tokenizer)


def test_a_note_tells_of_a_robot_that_has_changed(tokenizer: Tokenizer) -> None:
    bare = make_build(PREDATOR, Genome(GENOME.bits), tokenizer)
    assert bare.note is not None
    assert "does not say which sensors" in bare.note


def test_a_program_that_takes_too_much_is_refused(tmp_path: Path, tokenizer: Tokenizer) -> None:
    (tmp_path / "_say_who.j2").write_text('Banner DATA "#"\nBannerEnd DATA CR, 7(700)\n')
    with pytest.raises(BudgetError, match=r"main\.bsp: leaves \d+ of 2048 EEPROM bytes free"):
        make_build(PREDATOR, TABLE, tokenizer, tmp_path)


def test_a_source_that_the_tokenizer_refuses_is_located(
    tmp_path: Path, tokenizer: Tokenizer
) -> None:
    (tmp_path / "_say_who.j2").write_text("Banner DATA 1\nBannerEnd DATA oops\n")
    with pytest.raises(SourceError, match=r"^main\.bsp:\d+:\d+: "):
        make_build(PREDATOR, TABLE, tokenizer, tmp_path)


# --- the folder on the disk


def test_what_is_not_a_build_stays(tmp_path: Path, build: Build) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(FolderError, match=r"is not a build of cgagen alone \(notes.txt is in it\)"):
        write_build(tmp_path, build.files())
    assert listing(tmp_path) == {"notes.txt": b"mine"}
    write_build(tmp_path, build.files(), force=True)
    assert listing(tmp_path) == {"notes.txt": b"mine", **build.files()}


def test_a_run_folder_is_no_build_although_it_has_a_best_genome(
    tmp_path: Path, build: Build
) -> None:
    (tmp_path / "best.genome").write_text("mine")
    with pytest.raises(FolderError, match=r"best\.genome is in it"):
        write_build(tmp_path, build.files())


def test_a_build_with_a_file_of_the_users_is_not_replaced(tmp_path: Path, build: Build) -> None:
    folder = tmp_path / "out"
    write_build(folder, build.files())
    (folder / "notes.txt").write_text("mine")
    with pytest.raises(FolderError, match=r"notes\.txt is in it"):
        write_build(folder, build.files())


def test_a_file_in_the_way_is_never_overwritten(tmp_path: Path, build: Build) -> None:
    path = tmp_path / "out"
    path.write_text("mine")
    for force in (False, True):
        with pytest.raises(FolderError, match="is a file"):
            write_build(path, build.files(), force)
    assert path.read_text() == "mine"


def test_an_empty_folder_and_missing_parents_are_fine(tmp_path: Path, build: Build) -> None:
    (tmp_path / "empty").mkdir()
    write_build(tmp_path / "empty", build.files())
    write_build(tmp_path / "a" / "b", build.files())
    assert listing(tmp_path / "empty") == listing(tmp_path / "a" / "b") == build.files()


@pytest.mark.parametrize("stop_at", range(9))
@pytest.mark.parametrize("error", [StorageError("full"), KeyboardInterrupt()])
def test_a_stop_between_two_files_leaves_nothing(
    tmp_path: Path,
    build: Build,
    monkeypatch: pytest.MonkeyPatch,
    stop_at: int,
    error: BaseException,
) -> None:
    from cgagen.build import folder as module

    written: list[Path] = []

    def write(path: Path, content: bytes) -> None:
        if len(written) == stop_at:
            raise error
        written.append(path)
        path.write_bytes(content)

    monkeypatch.setattr(module, "write_bytes", write)
    with pytest.raises(type(error)):
        write_build(tmp_path / "out", build.files())
    assert list(tmp_path.iterdir()) == []


def test_a_failed_exchange_brings_the_old_build_back(
    tmp_path: Path, build: Build, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "out"
    write_build(folder, build.files())
    old = listing(folder)

    def refuse(source: str, target: str) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("cgagen.build.folder._exchanged", lambda one, other: False)
    monkeypatch.setattr(os, "rename", refuse)
    with pytest.raises(StorageError, match=r"out: cannot be written \(No space left on device\)"):
        write_build(folder, {**build.files(), "wiring.txt": b"new"})
    assert listing(folder) == old
    assert list(tmp_path.iterdir()) == [folder]


def test_a_killed_build_leaves_no_half_of_one(tmp_path: Path) -> None:
    program = (
        "import os, pathlib, cgagen.build.folder as f\n"
        "def write(path, content, n=[]):\n"
        "    n.append(path.write_bytes(content))\n"
        "    if len(n) == 3: os.kill(os.getpid(), 9)\n"
        "f.write_bytes = write\n"
        "f.write_build(pathlib.Path('out'), {str(i): b'x' for i in range(9)})\n"
    )
    code = subprocess.run(
        [sys.executable, "-c", program], cwd=tmp_path, check=False, stdin=subprocess.DEVNULL
    ).returncode
    assert code == -9
    assert not (tmp_path / "out").exists()


# --- the verb


def run(*words: str) -> int:
    return cli.main([*words])


def test_the_verb_writes_and_tells(
    tmp_path: Path, genome_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "out"
    assert run("build", str(genome_file), "-o", str(folder)) == 0
    out = capsys.readouterr().out
    for words in ("main.bsp", "locomotion.bs2", "BS2p", TABLE.digest, PREDATOR.digest, "next:"):
        assert words in out
    assert run("--json", "build", "--robot", "servobot-prey", "-o", str(tmp_path / "prey")) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["build"] == read_record(tmp_path / "prey")
    assert data["build"]["genome"] is None
    assert not (tmp_path / "prey" / "best.genome").exists()


def test_the_default_folder_is_named_after_the_robot(
    tmp_path: Path, genome_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run("build", str(genome_file)) == 0
    assert (tmp_path / "build" / "servobot-predator" / "build.json").is_file()


@pytest.mark.parametrize(
    ("words", "code", "sentence"),
    [
        ((), 2, "give a genome, or with --robot a prey"),
        (("--robot", "servobot-predator"), 3, "a predator hunts by a genome; give one"),
        (("--robot", "nobody"), 3, "nobody: no such robot"),
        (("GENOME", "--robot", "servobot-prey"), 3, "takes no genome; leave it out"),
        (("missing.genome",), 3, "missing.genome: cannot be read (No such"),
        (("GENOME", "--templates", "nowhere"), 3, "nowhere: no such folder"),
    ],
)
def test_what_cannot_be_built_is_one_sentence(
    words: tuple[str, ...],
    code: int,
    sentence: str,
    tmp_path: Path,
    genome_file: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    given = [str(genome_file) if word == "GENOME" else word for word in words]
    assert run("build", *given) == code
    assert sentence in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("case", ["predator-bs2sx", "prey-wary"])
def test_a_robot_of_ones_own_is_built_from_its_file(case: str, tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(CASES[case])
    words = [str(tmp_path / "g")] if genome_of(case) else []
    (tmp_path / "g").write_text(GENOME.bits)
    robot = ["--robot", str(tmp_path / "mine.toml"), "-o", str(tmp_path / "out")]
    assert run("build", *words, *robot) == 0
    assert (tmp_path / "out" / "robot.toml").read_text() == CASES[case]


# --- the wheel


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel as `pip` would get it, unpacked."""
    folder = tmp_path_factory.mktemp("wheel")
    program = (
        "import sys; from hatchling.builders.wheel import WheelBuilder\n"
        "print(next(WheelBuilder(sys.argv[1]).build(directory=sys.argv[2], versions=['standard'])))"
    )
    words = [sys.executable, "-c", program, str(ROOT), str(folder)]
    built = subprocess.run(
        words, capture_output=True, text=True, check=True, stdin=subprocess.DEVNULL
    )
    with zipfile.ZipFile(built.stdout.strip()) as archive:
        archive.extractall(folder / "site")
    return folder / "site"


def test_the_wheel_carries_templates_and_robots(wheel: Path) -> None:
    templates = {path.name for path in (ROOT / "templates").glob("*.j2")}
    assert {path.name for path in (wheel / "cgagen" / "_templates").glob("*.j2")} == templates
    robots = {path.name for path in (ROOT / "cgagen" / "robots").glob("*.toml")}
    assert {path.name for path in (wheel / "cgagen" / "robots").glob("*.toml")} == robots
    recorded = {path.name for path in (ROOT / "hil" / "traces").iterdir() if path.is_file()}
    assert {"hunt.log", "hunt.log.json", "rig.dbc", "vectors.csv"} <= recorded
    assert {path.name for path in (wheel / "hil" / "traces").iterdir()} == recorded


def test_an_installed_build_works_in_any_folder(
    wheel: Path, tmp_path: Path, genome_file: Path, build: Build
) -> None:
    words = [sys.executable, "-P", "-m", "cgagen", "build", str(genome_file), "-o", "out"]
    environment = {**os.environ, "PYTHONPATH": str(wheel)}
    where = "import cgagen.firmware.render as r; print(r.shipped_templates())"
    asked = subprocess.run(
        [sys.executable, "-P", "-c", where],
        env=environment,
        capture_output=True,
        check=True,
        stdin=subprocess.DEVNULL,
    )
    assert asked.stdout.decode().strip() == str(wheel / "cgagen" / "_templates")
    done = subprocess.run(
        words,
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        check=False,
        stdin=subprocess.DEVNULL,
    )
    assert done.returncode == 0, done.stderr
    assert listing(tmp_path / "out") == build.files()
