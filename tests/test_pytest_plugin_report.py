"""What a run with the plugin leaves behind."""

import json
import re
from pathlib import Path

from tests.plugin_runs import FIRMWARE, inside, run

OWN_TESTS = """
import pytest

@pytest.mark.hil_req("MINE")
def test_readings(hil_check, hil_target, hil_stimuli):
    hil_check(hil_target, hil_stimuli[:3])

def test_wrong(hil_target):
    from hil.target import Stimulus
    assert hil_target.decide(Stimulus((0,) * 6)).command == 7

@pytest.mark.hil_vectors("VECTORS")
def test_vectors(hil_vectors, hil_check, hil_registers):
    hil_check(hil_registers, hil_vectors)

def test_trace(hil_trace):
    pass

def test_folder(hil_artifacts, hil_vcd, hil_subject):
    from hil.emulated import robot_bench
    bench = robot_bench(hil_subject.robot, hil_subject.images)
    hil_vcd(bench, "own bench")
    bench.run(1_000_000)
    (hil_artifacts / "note.txt").write_text("kept")
"""


def test_what_a_run_leaves_behind_and_the_same_bytes_again(tmp_path: Path) -> None:
    vectors = str(FIRMWARE.parent / "hil" / "traces" / "vectors-prey.csv")
    (tmp_path / "test_own.py").write_text(OWN_TESTS.replace("VECTORS", vectors))
    (tmp_path / "ids.toml").write_text('MINE = "decides"\nOTHER = "is not tried"\n')
    left = []
    for name in ("one", "two"):
        out = tmp_path / name
        out.mkdir()
        words = (f"--hil-record={out}/told", "--hil-vcd=fail", f"--hil-artifacts={out}/kept")
        words += (f"--hil-report={out}", f"--hil-coverage={out}/lines.info")
        words += ("--hil-requirements=ids.toml", f"--hil-build={FIRMWARE / 'prey'}")
        ended = inside(tmp_path, *words)
        assert "1 failed, 3 passed, 1 skipped" in ended.stdout, ended.stdout
        assert "coverage prey/main.bsp: " in ended.stdout
        files = sorted(path for path in out.rglob("*") if path.is_file())
        left.append({str(path.relative_to(out)): path.read_bytes() for path in files})
    assert left[0] == left[1]
    told = left[0]
    kept = {name for name in told if name.startswith("kept")}
    wrong = "kept/test_own.py-test_wrong-emulator-named"
    assert kept == {
        f"{wrong}/failure.txt",
        f"{wrong}/target-decisions.jsonl",
        f"{wrong}/target.vcd",
        "kept/test_own.py-test_folder-named/note.txt",
    }
    assert b"assert 1 == 7" in told[f"{wrong}/failure.txt"]
    assert b"again: pytest 'test_own.py::test_wrong" in told[f"{wrong}/failure.txt"]
    assert b"main_line" in told[f"{wrong}/target.vcd"]
    records = {name for name in told if name.startswith("told")}
    assert "told/test_own.py-test_readings-named-emulator-target.log.json" in records
    assert "told/test_own.py-test_vectors-named-vectors-prey.csv-registers.jsonl" in records
    report = json.loads(told["hil-report.json"])
    assert report["verdict"] == "FAIL"
    assert [(row["id"], row["verdict"]) for row in report["requirements"]] == [
        ("MINE", "PASS"),
        ("OTHER", "UNPROVEN"),
    ]
    assert str(tmp_path) not in told["hil-report.html"].decode()
    assert told["lines.info"].startswith(b"TN:cgagen\nSF:prey/main.bsp\n")
    replayed = inside(
        tmp_path,
        *(f"--hil-build={FIRMWARE / 'prey'}", "-k", "test_trace"),
        "--hil-trace=one/told/test_own.py-test_readings-named-emulator-target.log",
    )
    assert "1 passed" in replayed.stdout, replayed.stdout


def test_what_cannot_be_written_is_a_sentence(tmp_path: Path) -> None:
    (tmp_path / "test_it.py").write_text("def test_it(hil_oracle): pass\n")
    words = (f"--hil-build={FIRMWARE / 'prey'}", "--hil-report=no/r.html")
    ended = inside(tmp_path, *words)
    assert (ended.returncode, "there is no folder no" in ended.stderr) == (4, True)
    ended = inside(tmp_path, words[0], "--hil-kills=no.json")
    assert (ended.returncode, "no.json: cannot be read" in ended.stderr) == (4, True)
    (tmp_path / "taken").write_text("")
    ended = inside(tmp_path, words[0], "--hil-coverage=taken/lines.info")
    assert (ended.returncode, "not written: taken: " in ended.stdout) == (4, True), ended.stdout
    assert "INTERNALERROR" not in ended.stdout


def test_what_could_not_be_set_up_says_nothing_of_the_firmware(tmp_path: Path) -> None:
    (tmp_path / "test_own.py").write_text("def test_it(hil_trace): pass\n")
    (tmp_path / "bad.csv").write_text("nothing\n")
    words = (f"--hil-build={FIRMWARE / 'prey'}", "--hil-report=r.json", "--hil-trace=bad.csv")
    ended = inside(tmp_path, *words)
    assert "bad.csv: line 1: column 1 is 'nothing'" in ended.stdout, ended.stdout
    assert json.loads((tmp_path / "r.json").read_text())["verdict"] == "BLOCKED"


def test_what_could_not_be_tried_is_unproven(tmp_path: Path) -> None:
    (tmp_path / "test_own.py").write_text(
        "import pytest\n"
        "@pytest.mark.hil_req('MINE')\n"
        "def test_it(hil_check, hil_oracle):\n"
        "    hil_check(hil_oracle, [])\n"
        "@pytest.mark.hil_needs('power')\n"
        "def test_power(hil_target): pass\n"
        "def test_trace(hil_trace): pass\n"
    )
    words = (f"--hil-build={FIRMWARE / 'prey'}", "--hil-report=r.json", "--hil-require")
    ended = inside(tmp_path, *words, "--hil-target=simulator")
    assert "2 failed, 1 error" in ended.stdout, ended.stdout
    report = json.loads((tmp_path / "r.json").read_text())
    assert report["verdict"] == report["requirements"][0]["verdict"] == "UNPROVEN"


def test_a_worker_that_dies_is_no_pass(tmp_path: Path) -> None:
    (tmp_path / "test_own.py").write_text(
        "import os\n"
        "def test_it(hil_check, hil_oracle, hil_stimuli):\n"
        "    hil_check(hil_oracle, hil_stimuli[:3])\n"
        "def test_dies(hil_subject):\n"
        "    os._exit(3)\n"
    )
    words = (f"--hil-build={FIRMWARE / 'prey'}", "--hil-report=r.json", "-n", "2")
    ended = run(tmp_path, *words)
    assert "1 failed, 1 passed" in ended.stdout, ended.stdout
    assert "BLOCKED: 1 workers have died" in ended.stdout
    assert json.loads((tmp_path / "r.json").read_text())["verdict"] == "BLOCKED"


def test_a_wire_has_room_for_one_worker(tmp_path: Path) -> None:
    (tmp_path / "test_own.py").write_text("def test_it(hil_target): pass\n")
    words = (f"--hil-build={FIRMWARE / 'prey'}", "--hil-target=serial:/dev/none", "-n", "2")
    ended = run(tmp_path, *words)
    assert (ended.returncode, "add --dist loadgroup" in ended.stderr) == (4, True), ended.stderr
    ended = run(tmp_path, *words, "--dist", "loadgroup")
    assert "/dev/none: cannot be opened" in ended.stdout
    (tmp_path / "test_own.py").write_text("def test_it(): pass\n")
    ended = run(tmp_path, "-n", "1", CGAGEN_HIL_TARGET="serial:/dev/none")
    assert "1 passed" in ended.stdout  # in the environment, it is said to every project


def test_workers_of_xdist_share_one_report(tmp_path: Path) -> None:
    (tmp_path / "test_own.py").write_text(
        "import pytest\n"
        "@pytest.mark.parametrize('part', range(4))\n"
        "def test_part(part, hil_check, hil_oracle, hil_stimuli):\n"
        "    hil_check(hil_oracle, hil_stimuli[part::4])\n"
    )
    reports = []
    for ran, more in ((inside, ()), (run, ("-n", "2"))):
        ended = ran(tmp_path, f"--hil-build={FIRMWARE / 'prey'}", "--hil-report=r.json", *more)
        assert "4 passed" in ended.stdout, ended.stdout
        reports.append(json.loads((tmp_path / "r.json").read_text()))
    alone, shared = (report["robots"] for report in reports)
    assert alone == shared
    assert len(alone[0]["trials"]) == 4
    assert sum(row["readings"][0] for row in alone[0]["states"]) > 200


def test_what_was_skipped_stands_everywhere_and_is_no_pass(tmp_path: Path) -> None:
    (tmp_path / "test_own.py").write_text(
        "import pytest\n"
        "def test_it(hil_check, hil_oracle, hil_stimuli):\n"
        "    hil_check(hil_oracle, hil_stimuli[:3])\n"
        "@pytest.mark.hil_needs('power')\n"
        "def test_power(hil_target): pass\n"
        "@pytest.mark.skip(reason='no <time>')\n"
        "def test_later(hil_subject): pass\n"
        "@pytest.mark.skip\n"
        "def test_of_something_else(): pass\n"
    )
    words = (f"--hil-build={FIRMWARE / 'prey'}", "--hil-report=r.json", "--hil-report=r.html")
    for more in ((), ("-n", "2")):
        ended = run(tmp_path, *words, *more, "--hil-target=simulator", "--junitxml=j.xml")
        assert "1 passed, 3 skipped" in ended.stdout, ended.stdout
        assert re.search(r"NOT TRIED test_own.py::test_later\S*: no <time>\n", ended.stdout)
        assert "cannot show: power" in ended.stdout
        assert "UNPROVEN: 2 tests of firmware were not tried" in ended.stdout
        report = json.loads((tmp_path / "r.json").read_text())
        assert report["verdict"] == "UNPROVEN"
        assert [row["test"].partition("[")[0] for row in report["not_tried"]] == [
            "test_own.py::test_later",
            "test_own.py::test_power",
        ]
        assert "no &lt;time&gt;" in (tmp_path / "r.html").read_text("utf-8")
        junit = (tmp_path / "j.xml").read_text("utf-8")
        assert junit.count('<property name="hil_verdict" value="NOT TRIED"') == 2
