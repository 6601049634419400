"""Any name that a robot's file may have: built, verified, said by chips and shown in reports."""

import json
import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from cgagen.bench_protocol import banner_in, parse_banner, plain
from cgagen.build import make_build
from cgagen.cli import cgagen
from cgagen.link.bench_hook import BenchHook
from cgagen.monitor.decode import Decoder
from cgagen.robot.reader import parse_robot
from cgagen.serve import serve
from cgagen.tokenizer import Tokenizer
from hil.conduct import try_conduct
from hil.emulated import robot_bench
from hil.equivalence import Verdict
from hil.subject import Subject, subject_of
from hil.wired import WiredTarget
from tests.firmware_cases import GENOME, PREDATOR, PREY, changed
from tests.plugin_runs import run

NAMES = [
    "my robot",
    "Käfer Nº 2",
    "機械の虫",
    "🐞 bug",
    "x" * 200,
    "a" * 31 + " tail of a name longer than a banner's",
    "\u2800",
    "\"quoted\" 'twice'",
    "{{ robot }} {% raw %} {0} %s",
    "back\\slash \\\\ \\n",
    "..",
    "../../etc/passwd",
    "-rf --force",
    "#1 M x 12345678 12345678",
    ">?!=:*#",
    "<script>alert(1)</script> &amp; ]]>",
    "' comment",
    "CON",
    " leading and trailing ",
    "$PBASIC 2.5",
]


def with_name(text: str, old: str, name: str) -> str:
    quoted = json.dumps(name, ensure_ascii=False)
    return changed(text, (f'name = "{old}"', f"name = {quoted}"))


@cache
def named(name: str, role: str = "prey") -> Subject:
    text = {"prey": PREY, "predator": PREDATOR}[role]
    robot = parse_robot(with_name(text, f"servobot-{role}", name), "mine.toml")
    with Tokenizer() as tokenizer:
        return subject_of(make_build(robot, GENOME if role == "predator" else None, tokenizer), "b")


@pytest.mark.parametrize("name", NAMES)
def test_a_robot_of_any_name_conducts_itself(name: str) -> None:
    one = named(name)
    trial = try_conduct(one)
    assert (trial.verdict, trial.reason) == (Verdict.PASS, "")
    for chip in ("main", "locomotion"):
        banner = banner_in(one.images[chip].eeprom)
        assert banner == one.banner(chip)
        assert banner is not None
        assert banner.robot == plain(name)
        assert len(banner.robot) <= 32
        assert banner.robot.isascii()


def test_another_name_or_source_in_a_banner_is_still_seen() -> None:
    one, other = named("my robot"), named("your robot")
    mixed = replace(one, images={**one.images, "main": other.images["main"]})
    assert "banner: says" in try_conduct(mixed).reason
    digests = {**one.source_digests, "locomotion": "00000000"}
    assert "banner: says" in try_conduct(replace(one, source_digests=digests)).reason


def call(*words: str) -> Result:
    return CliRunner().invoke(cgagen, list(words))


@pytest.mark.parametrize("name", ["my robot", "<b>Käfer</b> {{ 1 }} \"'\\", "x" * 200])
def test_verify_of_any_name(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "mine.toml"
    file.write_text(with_name(PREY, "servobot-prey", name), "utf-8")
    assert call("build", "--robot", "mine.toml").exit_code == 0
    built = tmp_path / "build" / plain(name)
    assert (built / "wiring.txt").read_text("utf-8").startswith(f"Wiring of {plain(name)}, a prey")
    words = ("--build", str(built), "--level", "smoke", "--report", "r.html", "--report", "r.json")
    done = call("--json", "verify", *words)
    data = json.loads(done.stdout)
    assert (done.exit_code, data["verdict"]) == (0, "PASS"), data["trials"]
    assert data["robot"]["name"] == name
    page = Path("r.html").read_text("utf-8")
    assert "<b>Käfer" not in page
    assert json.loads(Path("r.json").read_text("utf-8"))["robots"][0]["name"] == name


def test_a_robot_of_an_odd_name_on_a_wire() -> None:
    one = named("my röbot & co")
    bench = robot_bench(one.robot, one.images)
    with serve(bench, {"main": "rfc2217:0"}) as server:
        port = server.endpoints[0].url
        with WiredTarget(port, one, gaps=False, reset=True) as target:
            assert target.identity().robot == plain(one.robot.name)
        with BenchHook(port, gaps=False) as hook:
            hook.enter()
            assert hook.greeting is not None
            assert hook.greeting.robot == "my_r_bot_co"


def test_a_banner_of_a_plain_name_is_the_robots() -> None:
    one = named("my robot", "predator")
    banner = f"#1 M my_robot {one.genome_digest} {one.source_digests['main']}\r"
    assert parse_banner(banner.rstrip()) == one.banner("main")
    lines = list(Decoder(one.robot).lines(banner.encode()))
    assert "read as" not in lines[0].text


def test_junit_and_terminal_of_an_odd_name(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(with_name(PREY, "servobot-prey", "<🐞> & \\ \"'"), "utf-8")
    (tmp_path / "test_own.py").write_text(
        "def test_it(hil_check, hil_oracle, hil_stimuli):\n"
        "    hil_check(hil_oracle, hil_stimuli[:3])\n"
    )
    ended = run(tmp_path, "--hil-robot=mine.toml", "--junitxml=j.xml", "--hil-report=r.html")
    assert "1 passed" in ended.stdout, ended.stdout
    assert "PASS <🐞> & \\ \"' on simulator" in ended.stdout
    assert ElementTree.parse(tmp_path / "j.xml").getroot() is not None
    assert "&lt;🐞&gt; &amp;" in (tmp_path / "r.html").read_text("utf-8")
