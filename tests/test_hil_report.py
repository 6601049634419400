"""The report: what it says, that it stands alone, and that equal trials give equal bytes."""

import json
import re
import shutil
from collections import Counter
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest

from cgagen.errors import FolderError, RunError
from cgagen.stamp.image import Image
from cgagen.tokenizer import Tokenizer
from cgagen.words import Situation, situation_name
from hil.benches import Counted, looking
from hil.boundaries import boundaries, steps_of
from hil.coverage_files import write_coverage
from hil.emulated import PinsTarget
from hil.equivalence import Verdict, compare
from hil.evidence import Evidence, key_of, merged
from hil.proof import prove
from hil.registers import RegisterTarget
from hil.report import read_kills, report_of, write_reports
from hil.requirements import OURS, matrix, read_requirements
from hil.stimuli import Level, neutral, stimuli_of, thresholds
from hil.subject import Subject, read_subject
from hil.target import Observation, Stimulus
from hil.timing import try_timing
from hil.verify import try_table, verify

ROOT = Path(__file__).parent.parent
FIRMWARE = ROOT / "firmware"
AGAIN = "cgagen verify firmware/reference.genome"

Robot = dict[str, Any]


@pytest.fixture(scope="module")
def predator() -> Subject:
    return read_subject(FIRMWARE / "predator")


@pytest.fixture(scope="module")
def robots(predator: Subject, tokenizer: Tokenizer) -> list[Robot]:
    """All that a run finds out, for both robots."""
    prey = read_subject(FIRMWARE / "prey")
    return [verify(one, tokenizer.compile, Level.SMOKE).evidence.data() for one in (predator, prey)]


@pytest.fixture(scope="module")
def page(robots: list[Robot], tmp_path_factory: pytest.TempPathFactory) -> str:
    folder = tmp_path_factory.mktemp("page")
    write_reports([folder], report_of(robots, "smoke", 1, AGAIN, [kills_of(robots[0])]))
    return (folder / "hil-report.html").read_text("utf-8")


def kills_of(robot: Robot) -> dict[str, Any]:
    """A kill matrix as `make hil-mutants` writes it."""
    row = {"chip": "main", "kind": "threshold", "mutants": 9, "killed": 6, "equal": 1}
    row |= {"same_image": 0, "survivors": 2, "by": {"decide": 6}}
    told = {"chip": "main", "line": 7, "kind": "threshold", "change": "a -> <b>", "reason": None}
    return {
        "format": "cgagen-kills-1",
        "images": robot["images"],
        "rows": [row],
        "survivors": [told, told | {"reason": "looked at"}],
        "proven": [told | {"reason": "PASS: proven"}],
    }


class Tags(HTMLParser):
    """Which tags open and close, and what a page asks for from elsewhere."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.asked: list[str] = []
        self.seen: Counter[str] = Counter()
        self.ids: set[str] = set()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.seen[tag] += 1
        if tag not in ("meta", "br"):
            self.open.append(tag)
        self.ids |= {value or "" for name, value in attrs if name == "id"}
        self.asked += [v or "" for name, v in attrs if name in ("src", "href", "srcset")]

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def test_the_page_stands_alone(page: str) -> None:
    tags = Tags()
    tags.feed(page)
    assert tags.open == []
    assert all(word.startswith("#") and word[1:] in tags.ids for word in tags.asked)
    assert not tags.seen.keys() & {"script", "link", "img", "iframe"}
    assert not re.search(r"https?:|url\(|@import", page)


def test_the_page_has_every_table(page: str, robots: list[Robot]) -> None:
    for situation in Situation:
        for what in ("object", "target"):
            assert f">{situation_name(situation, what).replace('_', ' ')}</th>" in page
    assert page.count('class="cell good"') == 40
    assert page.count('class="cell none"') == 24
    assert "64 of 64 entries" in page
    assert all(word in page for word in ("rear left nearest", "both right open", "calm"))
    for limit in robots[0]["boundaries"] + robots[1]["boundaries"]:
        assert f">{limit['sensor']}</th>" in page
        assert all(tried == agreed > 0 for tried, agreed in limit["steps"].values())
    assert "6,000 of 55,296 cells agree" in page
    assert page.count('open">a sample<') == 2
    longest_ms = robots[0]["timing"]["decision_ns"] / 1e6
    assert f"<b>{longest_ms:.1f} ms</b>longest decision" in page
    assert "not compared with silicon" in page
    assert all(f">{name}</th>" in page for name in ("main.bsp", "locomotion.bs2"))
    assert AGAIN in page
    for digest in (*robots[0]["images"].values(), robots[0]["genome"], robots[0]["robot"]):
        assert digest in page


def test_the_kill_matrix_is_of_these_images_or_left_out(page: str, robots: list[Robot]) -> None:
    assert page.count("make hil-mutants") == 1  # the prey has none
    assert "6 of 9" in page
    assert "a -&gt; &lt;b&gt;" in page
    other = kills_of(robots[0]) | {"images": {"main": "0", "locomotion": "0"}}
    assert report_of(robots[:1], "smoke", 1, AGAIN, [other])["robots"][0]["kills"] is None
    sums = report_of(robots[:1], "smoke", 1, AGAIN, [kills_of(robots[0])])["robots"][0]["kills"]
    assert (sums["sums"]["reviewed"], sums["sums"]["survived"]) == (1, 1)


def test_equal_trials_give_equal_bytes_without_folders(
    robots: list[Robot], predator: Subject, tokenizer: Tokenizer, tmp_path: Path
) -> None:
    again = [verify(predator, tokenizer.compile, Level.SMOKE).evidence.data(), robots[1]]
    texts = []
    for number, data in enumerate((robots, again[::-1])):
        folder = tmp_path / str(number)
        folder.mkdir()
        files = write_reports([folder], report_of(data, "smoke", 1, AGAIN))
        texts.append([file.read_bytes() for file in files])
    assert texts[0] == texts[1]
    for text in texts[0]:
        assert str(ROOT).encode() not in text
        assert str(tmp_path).encode() not in text
    data = json.loads(texts[0][0])
    assert (data["format"], data["verdict"]) == ("cgagen-hil-report-1", "PASS")
    assert [robot["where"] for robot in data["robots"]] == ["firmware/predator", "firmware/prey"]


def test_a_wrong_gene_stands_in_the_page(
    predator: Subject, tokenizer: Tokenizer, tmp_path: Path
) -> None:
    image = predator.images["main"]
    eeprom = bytearray(image.eeprom)
    genes = bytes(predator.genome.commands() if predator.genome else ())
    eeprom[eeprom.index(genes)] ^= 1
    wrong = replace(
        predator,
        images={**predator.images, "main": Image(image.model, bytes(eeprom), slot=image.slot)},
    )
    report = report_of(
        [verify(wrong, tokenizer.compile, Level.SMOKE).evidence.data()], "smoke", 1, AGAIN
    )
    assert report["verdict"] == "FAIL"
    robot = report["robots"][0]
    assert robot["smallest"]["reading"] == "0,0,0/--/0,0"
    assert "DATA" in robot["smallest"]["lines"][0]["text"]
    state = robot["states"][0]
    assert state["table"] == [1, 0]
    assert state["readings"][1] == 0 < state["readings"][0]
    assert (robot["genes"]["agreed"], robot["genes"]["by_readings"]) == (63, 39)
    (file,) = write_reports([tmp_path / "r.html"], report)
    page = file.read_text("utf-8")
    assert page.count('class="cell bad"') == 1
    assert "✗ FAIL" in page
    assert "The smallest difference" in page
    assert "obstacle no object, target no target" in page


def test_parts_of_a_run_add_up(predator: Subject, tokenizer: Tokenizer) -> None:
    readings = stimuli_of(predator.robot, Level.SMOKE)[:200]

    def data(stimuli: list[Stimulus], whole: bool) -> Robot:
        evidence = Evidence(predator)
        with RegisterTarget(predator, tokenizer.compile) as target:
            trial = compare(predator, target, stimuli, heard=evidence.ear(target.url))
            if whole:
                evidence.table(try_table(predator, target))
        evidence.trial("all", trial)
        return evidence.data()

    one, two, both = data(readings[:90], True), data(readings[90:], False), data(readings, True)
    assert key_of(one) == key_of(two)
    total = merged(one, two)
    for key in ("states", "boundaries", "slowest"):
        assert total[key] == both[key], key
    assert merged(two, one)["states"] == both["states"]


def test_the_proof_that_tells_more_is_kept(predator: Subject) -> None:
    few, more = Evidence(predator), Evidence(predator)
    few.proof(prove(predator, 50))
    more.proof(prove(predator, 60))
    for first, second in ((few, more), (more, few)):
        assert merged(first.data(), second.data())["proof"]["tried"] == 60
    lost = few.data()
    lost["proof"] = lost["proof"] | {"verdict": "FAIL"}
    assert merged(lost, more.data())["proof"]["verdict"] == "FAIL"
    assert report_of([lost], "smoke", 1, AGAIN)["verdict"] == "FAIL"


def test_executed_lines_add_up_over_processes(
    predator: Subject, tokenizer: Tokenizer, tmp_path: Path
) -> None:
    def data(*stimuli: Stimulus) -> Robot:
        counted, evidence = Counted(), Evidence(predator)
        with looking(counted), PinsTarget(predator) as target:
            for one in stimuli:
                target.decide(one)
        evidence.count(counted, tokenizer.compile)
        return evidence.data()

    calm = neutral(predator.robot)
    near = replace(calm, sonars=(100, 0, 0))
    one, other, both = data(calm), data(near), data(calm, near)
    hits = [
        {row[0] for row in part["coverage"]["main"]["lines"] if row[1]} for part in (one, other)
    ]
    whole = {row[0] for row in both["coverage"]["main"]["lines"] if row[1]}
    assert hits[0] != hits[1]
    assert hits[0] | hits[1] == whole
    total = merged(one, other)
    assert {row[0] for row in total["coverage"]["main"]["lines"] if row[1]} == whole
    lines = write_coverage(tmp_path / "cov", [total])
    assert any(
        re.search(r"predator/main\.bsp: \d+ of \d+ lines.*not met in full", x) for x in lines
    )
    tracefile = (tmp_path / "cov" / "hil-coverage.info").read_text()
    assert tracefile.count("SF:predator/") == 2
    assert "-----" in (tmp_path / "cov" / "hil-coverage.txt").read_text()
    line = next(row for row in lines if "entries" in row)
    assert line.startswith("coverage predator: 0 of 64 entries of the table; not met: 0-63")


def test_limits_are_met_at_the_very_count(predator: Subject) -> None:
    limits = boundaries(predator.robot)
    assert len(limits) == 15
    *sonars, left, right = predator.robot.situation_counts
    assert {one.counts for one in limits} == {*sonars, *left, *right}
    met = {step for one in thresholds(predator.robot) for step in steps_of(one, limits)}
    assert met == {(number, step) for number in range(15) for step in (-1, 0, 1)}


def test_what_no_reading_tried_is_not_green(predator: Subject) -> None:
    evidence = Evidence(predator)
    ear = evidence.ear("emulator")
    ear(neutral(predator.robot), Observation(0, 4, 0), Observation(1, 4, 0), True)
    report = report_of([evidence.data()], "smoke", 1, AGAIN)
    assert report["verdict"] == Verdict.UNPROVEN
    assert report["robots"][0]["genes"]["by_readings"] == 1


def test_timing_is_of_the_robot(predator: Subject) -> None:
    trial, timing = try_timing(predator)
    assert trial.verdict is Verdict.PASS
    assert timing is not None
    assert timing.longest_frame_ns <= 45_000_000
    assert timing.jitter_ns < 1_000


def test_wrong_files_are_sentences(tmp_path: Path) -> None:
    for name, words in (("r.pdf", "ends in .html or .json"), ("no/r.html", "there is no folder")):
        with pytest.raises(FolderError, match=re.escape(words)):
            write_reports([tmp_path / name], {})
    (tmp_path / "k.json").write_text('{"format": "other"}')
    with pytest.raises(RunError, match="is no kill matrix"):
        read_kills(tmp_path / "k.json")
    (tmp_path / "r.toml").write_text("A = 1")
    with pytest.raises(RunError, match="an id and a sentence"):
        read_requirements(tmp_path / "r.toml")


def test_requirements_have_the_worst_of_their_tests() -> None:
    tests = {"A": ["t1", "t2"], "B": ["t3"], "D": ["t4"], "E": ["t1", "t5"]}
    outcomes = {"t1": "passed", "t2": "failed", "t3": "skipped", "t4": "BLOCKED", "t5": "UNPROVEN"}
    rows = matrix({"A": "first", "C": "none"}, tests, outcomes)
    assert [(row["id"], row["verdict"]) for row in rows] == [
        ("A", "FAIL"),
        ("C", "UNPROVEN"),
        ("B", "UNPROVEN"),
        ("D", "BLOCKED"),
        ("E", "UNPROVEN"),
    ]


def test_every_requirement_has_a_test_and_every_id_a_sentence() -> None:
    marked = {
        one
        for path in (ROOT / "hil").glob("test_*.py")
        for row in re.findall(r"hil_req\(([^)]*)\)", path.read_text("utf-8"))
        for one in re.findall(r'"(.*?)"', row)
    }
    assert marked == set(read_requirements(OURS))


@pytest.mark.skipif(shutil.which("chromedriver") is None, reason="no chromedriver on this machine")
@pytest.mark.parametrize("width", [390, 1200])
def test_a_browser_shows_it_without_scrolling_sideways(
    page: str, tmp_path: Path, width: int
) -> None:
    from selenium.webdriver import Chrome, ChromeOptions
    from selenium.webdriver.chrome.service import Service

    (tmp_path / "page.html").write_text(page, "utf-8")
    options = ChromeOptions()
    for word in ("--headless=new", "--no-sandbox", f"--user-data-dir={tmp_path / 'profile'}"):
        options.add_argument(word)
    with Chrome(options=options, service=Service(shutil.which("chromedriver"))) as browser:
        size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False}
        browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
        browser.get((tmp_path / "page.html").as_uri())
        assert browser.execute_script("return document.documentElement.scrollWidth") <= width
        assert browser.get_log("browser") == []
        assert "PASS" in browser.title
