"""`cgagen trace`, and `cgagen verify --trace`, as their users call them."""

import json
import re
import subprocess
import sys
from io import BytesIO
from pathlib import Path
from typing import Any

import can
import pytest

from cgagen.cli import main
from cgagen.robot import load_robot
from cgagen.words import Role
from hil.emulated import robot_bench
from hil.pipe import BytePipe
from hil.subject import read_subject
from hil.traces import listening, read_trace
from hil.traces.shipped import EPISODES, FOLDER
from tests.subjects import FIRMWARE

GENOME = str(FIRMWARE / "reference.genome")
PREDATOR = load_robot("servobot-predator")


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str, str]:
    capsys.readouterr()
    code = main(list(words))
    out = capsys.readouterr()
    return code, out.out, out.err


def data(capsys: pytest.CaptureFixture[str], *words: str) -> dict[str, Any]:
    code, out, err = run(capsys, "--json", "trace", *words)
    assert code == 0, err
    found: dict[str, Any] = json.loads(out)
    return found


def test_the_papers_hunt_is_recorded_as_it_lies_in_the_project(
    capsys: pytest.CaptureFixture[str], folder: Path
) -> None:
    said = data(capsys, "record", GENOME, "-o", "hunt.log")
    assert said == {
        "robot": "servobot-predator",
        "target": "simulator",
        "genome": read_subject(FIRMWARE / "predator").genome.digest,  # type: ignore[union-attr]
        "readings": 54,
        "decisions": 54,
        "left_out": 0,
        "files": ["hunt.log", "hunt.log.json", "rig.dbc"],
    }
    for name in said["files"]:
        assert (folder / name).read_bytes() == (FOLDER / name).read_bytes()
    steps = EPISODES["hunt-prey.log"][2]
    data(capsys, "record", GENOME, "--of", "prey", "-o", "p.log", "--steps", str(steps))
    assert (folder / "p.log.json").read_bytes() == (FOLDER / "hunt-prey.log.json").read_bytes()


def test_the_programs_decide_when_they_are_asked_to(
    capsys: pytest.CaptureFixture[str], folder: Path
) -> None:
    build = str(FIRMWARE / "predator")
    words = ["record", GENOME, "--build", build, "--target", "emulator", "--steps", "3"]
    data(capsys, *words, "-o", "a.log")
    row = json.loads((folder / "a.log.json").read_text())
    images = read_subject(FIRMWARE / "predator").images
    assert row["images"] == {name: image.digest for name, image in images.items()}
    assert all(one["latency_us"] > 1_000 for one in data(capsys, "show", "a.log")["rows"])


def test_the_programs_that_decide_are_of_what_the_trace_says(
    capsys: pytest.CaptureFixture[str], folder: Path
) -> None:
    Path("g7.genome").write_text(Path(GENOME).read_text().replace("\n100 000", "\n101 000", 1))
    build = ["--build", str(FIRMWARE / "predator"), "--target", "emulator", "-o", "a.log"]
    for words in (
        ["g7.genome", "--steps", "3"],
        ["g7.genome", "--sweep"],
        ["--robot", "servobot-prey", "--sweep"],
        [GENOME, "--of", "prey"],
    ):
        code, _, err = run(capsys, "trace", "record", *words, *build)
        assert (code, "that was named beside it is" in err) == (9, True), err
    assert [one.name for one in folder.iterdir()] == ["g7.genome"]


def test_levels_sweeps_and_other_traces_are_sources(capsys: pytest.CaptureFixture[str]) -> None:
    prey = ["--robot", "servobot-prey"]
    level = data(capsys, "record", *prey, "--level", "smoke", "--seed", "3", "-o", "l.csv")
    assert level["readings"] > 300
    row = json.loads(Path("l.csv.json").read_text())
    assert (row["seed"], row["source"]) == (3, {"level": "smoke"})
    data(capsys, "record", *prey, "--sweep", "-o", "s.log")
    data(capsys, "record", *prey, "--from", "s.log", "-o", "again.log")
    assert Path("again.log").read_bytes() == Path("s.log").read_bytes()
    code, _, err = run(
        capsys, "trace", "record", "--robot", "servobot-predator", "--sweep", "-o", "x.log"
    )
    assert (code, "needs GENOME" in err) == (2, True)
    code, _, err = run(capsys, "trace", "record", "-o", "x.log")
    assert (code, "an episode needs GENOME" in err) == (2, True)
    assert not Path("x.log").exists()


def test_a_robot_at_work_is_listened_to(capsys: pytest.CaptureFixture[str]) -> None:
    one = read_subject(FIRMWARE / "predator")
    with BytePipe(robot_bench(one.robot, one.images)) as pipe:
        words = ["--port", pipe.url, "--readings", "2", "--for", "500", "-o", "t.csv"]
        said = data(capsys, "record", GENOME, *words)
    assert (said["target"], said["decisions"]) == ("serial", 2)
    assert json.loads(Path("t.csv.json").read_text())["clock"] == "host"


WORK = ":{} F24666 R24666 L24666 LL0 LR0 AL1 AR1 S0 C4\r"


@pytest.mark.parametrize(
    ("text", "readings"), [(WORK.format(7) + WORK.format(8), 2), (WORK.format(7)[:-9], 0)]
)
def test_a_robot_that_is_unplugged(
    text: str, readings: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """What it has said until then is not thrown away."""

    class Unplugged(BytesIO):
        in_waiting = 7

        def read(self, size: int | None = -1) -> bytes:
            data = super().read(size)
            if not data:
                raise OSError("unplugged")
            return data

    monkeypatch.setattr(listening, "locked_port", lambda _: Unplugged(text.encode()))
    asked = ("--port", "/dev/x", "-o", "t.csv")
    code, _, err = run(capsys, "trace", "record", GENOME, *asked)
    assert (code, "/dev/x: lost (unplugged); look at the cable" in err) == (7, True)
    assert ("; what was heard before is in t.csv" in err) == bool(readings)
    lines = Path("t.csv").read_text().splitlines()[1:] if readings else []
    assert len(lines) == readings
    assert Path("t.csv").exists() == bool(readings)


def test_an_emulated_robot_is_listened_to(capsys: pytest.CaptureFixture[str]) -> None:
    port = f"emu:{FIRMWARE / 'predator'}"
    assert data(capsys, "record", GENOME, "--port", port, "--readings", "1", "-o", "t.csv")


def test_show_names_what_a_reading_means(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, _ = run(capsys, "trace", "show", str(FOLDER / "vectors-prey.csv"))
    assert code == 0
    lines = out.splitlines()
    assert lines[0].split() == [
        *("seq", "time_s", "front_left", "front_right", "left", "right"),
        *("rear_left", "rear_right", "touch", "reason", "state", "movement"),
    ]
    assert lines[1].split() == [
        *("1", "0.000", "0", "0", "0", "0", "0", "0", "--", "nothing_near", "0", "WAIT")
    ]
    assert "both_left_open" in lines[10]
    assert lines[-1] == "servobot-prey: 14 readings, 14 decisions by hand"
    rows = data(capsys, "show", str(FOLDER / "wall.log"))["rows"]
    assert rows[8]["touched"] == {"left": True, "right": False}
    first = data(capsys, "show", str(FOLDER / "hunt.log"))["rows"][0]
    assert (first["obstacle"], first["target"], first["movement"], first["recorded"]) == (
        *("far_left", "no_target", "RIGHT_FORWARD"),
        True,
    )


def test_a_state_that_was_not_recorded_stands_in_brackets(
    capsys: pytest.CaptureFixture[str],
) -> None:
    hunt = str(FOLDER / "hunt.log")
    data(capsys, "convert", hunt, "r.csv", "--readings-only")
    _, out, _ = run(capsys, "trace", "show", "r.csv")
    _, full, _ = run(capsys, "trace", "show", hunt)
    assert out.splitlines()[1].split()[-2:] == ["(32)", "-"]
    assert full.splitlines()[1].split()[-2:] == ["32", "RIGHT_FORWARD"]


def test_convert_there_and_back_gives_the_same_bytes(capsys: pytest.CaptureFixture[str]) -> None:
    data(capsys, "convert", str(FOLDER / "sweep.log"), "s.csv")
    data(capsys, "convert", "s.csv", "s.log")
    for name in ("s.log", "s.log.json"):
        there = FOLDER / name.replace("s.", "sweep.", 1)
        assert Path(name).read_bytes() == there.read_bytes()


def test_other_tools_files_need_a_robot(capsys: pytest.CaptureFixture[str]) -> None:
    trace = read_trace(FOLDER / "hunt.log", PREDATOR)
    with can.LogReader(FOLDER / "hunt.log") as frames, can.Logger("h.asc") as writer:
        for one in frames:
            one.channel = 0
            writer.on_message_received(one)
    code, _, err = run(capsys, "trace", "show", "h.asc")
    assert code == 3
    assert "no h.asc.json says whose it is; name the robot with --robot" in err
    robot = ["--robot", "servobot-predator"]
    data(capsys, "convert", "h.asc", "h.log", *robot)
    assert read_trace(Path("h.log"), PREDATOR).samples == trace.samples
    assert Path("h.log").read_bytes() == (FOLDER / "hunt.log").read_bytes()


BAD = {
    "--level smoke --sweep": "--level and --sweep: both say which readings",
    "--level smoke --steps 4": "--steps is of an episode, and --level is none",
    "--sweep --of prey": "--of is of an episode, and --sweep is none",
    "--from a.log --hold": "--hold is of an episode, and --from is none",
    "--port x --target emulator": "--port listens to a robot that decides by itself",
    "--readings 3": "--readings is for --port",
    "--target nonsense": "--target: nonsense: no such target",
    "--target can:virtual": "--target: can:virtual: no name of a rig",
    "--steps 0": "0 is not in the range",
}


@pytest.mark.parametrize("words", BAD)
def test_wrong_words_are_usage_errors(
    capsys: pytest.CaptureFixture[str], words: str, folder: Path
) -> None:
    code, _, err = run(capsys, "trace", "record", GENOME, "-o", "x.log", *words.split())
    assert (code, BAD[words] in err) == (2, True), err
    assert list(folder.iterdir()) == []


def test_what_is_there_is_kept(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["trace", "record", GENOME, "-o", "x.log", "--steps"]
    assert run(capsys, *words, "2")[0] == 0
    code, _, err = run(capsys, *words, "3")
    assert (code, "x.log: is there already" in err) == (3, True)
    assert run(capsys, *words, "3", "--force")[0] == 0


@pytest.mark.parametrize(
    ("output", "said"),
    [
        ("x.blf", "x.blf: traces are written as .log or .csv"),
        ("none/x.log", "none/x.log: there is no folder none"),
        ("x.log", "x.log: is there already"),
    ],
)
def test_a_name_that_cannot_be_is_refused_before_anybody_listens(
    capsys: pytest.CaptureFixture[str], output: str, said: str
) -> None:
    Path("x.log").write_text("mine")
    port = ["--port", "/dev/no-such-port"]
    code, _, err = run(capsys, "trace", "record", GENOME, *port, "-o", output)
    assert (code, said in err) == (3, True), err
    assert Path("x.log").read_text() == "mine"


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.log", "(0.0) x", "a.log: line 1: "),
        ("a.csv", "t_ms\n", "a.csv: line 1: column 2 is 'nothing'"),
        ("a.blf", "nonsense", "a.blf: behind frame 0: python-can cannot read on"),
        ("none.log", None, "none.log: no such file"),
        ("a.txt", "x", "a.txt: a trace's name ends in"),
    ],
)
def test_what_is_no_trace_is_one_sentence(
    capsys: pytest.CaptureFixture[str], name: str, content: str | None, said: str
) -> None:
    if content is not None:
        Path(name).write_text(content)
    robot = [] if content is None else ["--robot", "servobot-predator"]
    code, out, err = run(capsys, "trace", "show", name, *robot)
    assert (code, out) == (3, "")
    assert err.startswith(f"cgagen: {said}")
    assert len(err.splitlines()) == 1


def test_verify_replays_a_trace(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["verify", GENOME, "--build", str(FIRMWARE / "predator"), "--reading", "0,0,0/--/0,0"]
    code, out, _ = run(capsys, *words, "--trace", str(FOLDER / "wall.log"))
    assert (code, out.splitlines()[-1]) == (11, "UNPROVEN")  # what is left out beside a reading
    assert re.search(r"\nwall\.log on emulator +PASS ", out)
    text = (FOLDER / "vectors.csv").read_text().replace("1000,9.9,", "1000,10.1,")
    Path("mine.csv").write_text(text)
    code, out, _ = run(capsys, *words, "--trace", "mine.csv")
    assert code == 9
    assert "mine.csv: line 5: reading 2 at 1.000000 s, 1986,0,0/--/0,0" in out
    assert "the trace has state 40, the simulator state 48" in out


def test_help_and_show_import_no_can() -> None:
    """python-can is for its own formats; a .log is read without it."""
    program = (
        "import sys; from cgagen.cli import main\n"
        f"main(['trace', 'show', {str(FOLDER / 'hunt.log')!r}]); main(['trace', '--help'])\n"
        "sys.exit('can' in sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, check=False, stdin=subprocess.DEVNULL
    )
    assert done.returncode == 0


def test_the_prey_of_the_hunt_is_the_preys(capsys: pytest.CaptureFixture[str]) -> None:
    code, _, err = run(
        capsys, "trace", "show", str(FOLDER / "hunt-prey.log"), "--robot", "servobot-predator"
    )
    assert code == 3
    assert "recorded with servobot-prey, a prey, and servobot-predator is a predator" in err
    assert Role.PREY in EPISODES["hunt-prey.log"]


def test_info_says_where_a_trace_comes_from(capsys: pytest.CaptureFixture[str]) -> None:
    hunt = Path(__file__).parent.parent / "hil" / "traces" / "hunt.log"
    assert main(["--json", "info", str(hunt)]) == 0
    data = json.loads(capsys.readouterr().out)
    assert (data["kind"], data["target"]) == ("trace", "simulator")
    assert main(["info", str(hunt)]) == 0
    assert "simulator" in capsys.readouterr().out
