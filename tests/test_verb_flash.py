"""`cgagen flash` against emulated Stamps behind real sockets, and which port is which."""

import json
import os
import pty
from pathlib import Path

import pytest

from cgagen.build import flashing, read_image
from cgagen.build.checked import checked_images
from cgagen.build.flashing import Identify, assign
from cgagen.cli import main
from cgagen.emulator.bench import Bench
from cgagen.emulator.host_port import HostPort
from cgagen.emulator.loader import Atn
from cgagen.emulator.programs import bench_of_image
from cgagen.errors import FlashError, RigError
from cgagen.flash import FlashReport, Module, flash_image, identify_port, plan_of
from cgagen.flash import programmer as programmer_module
from cgagen.flash.line import Line
from cgagen.flash.programmer import program
from cgagen.flash.verify import read_back
from cgagen.link import ports as ports_module
from cgagen.link.ports import PortInfo
from cgagen.robot import load_robot
from cgagen.serve import Server, serve
from cgagen.stamp.chips import Chip, chip
from cgagen.stamp.image import SENT, Image, Use
from cgagen.stamp.packets import packets_of
from hil.emulated import robot_bench
from tests.flash_cases import CHIPS, PREDATOR, blank, robot
from tests.other_program import opened_by_another


def holds(bench: Bench, name: str, image: Image) -> bool:
    eeprom = bench.chip(name).machine.memory.slots[0].frozen()
    plan = plan_of(image)
    return all(
        eeprom[place] == image.eeprom[place]
        for block in plan.blocks
        for place in range(16 * block, 16 * block + 16)
    )


# -- In process: the two that were written from the documents apart ---------------------------


@pytest.mark.parametrize("atn", Atn)
@pytest.mark.parametrize("name", CHIPS)
def test_the_emulated_loader_and_the_programmer_agree(name: str, atn: Atn) -> None:
    image = read_image(PREDATOR, name)
    port = HostPort(bench_of_image(blank(image.model.name)), timeout=0.05, atn=atn)
    report = program(Line(port, port), "emulated", plan_of(image))
    # The locomotion controller says who it is when its legs stand, later than anyone listens.
    assert (report.attempts, report.talks) == (1, name == "main")
    assert holds(port.bench, "main", image)
    assert port.faults == []
    letter = {"main": "M", "locomotion": "L"}[name]
    port.timeout = 4.0
    assert f"1 {letter} servobot-predator" in port.read(40).decode()


@pytest.mark.parametrize(
    ("model", "legs"),
    [("BS2", 24), ("BS2e", 24), ("BS2sx", 24), ("BS2p", 24), ("BS2p", 40), ("BS2pe", 40)],
)
def test_the_emulated_loader_takes_every_slot_of_every_model(model: str, legs: int) -> None:
    row = chip(model)
    port = HostPort(bench_of_image(blank(model)), timeout=0.05, legs=legs)
    for slot in {0, 1, row.slots - 1} & set(range(row.slots)):
        eeprom = bytes((slot + place) % 251 for place in range(2044)) + bytes(4)
        image = Image(row, eeprom, slot=slot)
        report = program(Line(port, port), "emulated", plan_of(image))
        assert report.module.pins == legs
        memory = port.bench.chip("main").machine.memory
        assert memory.slots[slot].frozen() == eeprom


# -- Over RFC 2217 ----------------------------------------------------------------------------


def test_both_stamps_are_programmed_verified_and_run(capsys: pytest.CaptureFixture[str]) -> None:
    with robot() as (bench, urls):
        words = ["--main", urls["main"], "--locomotion", urls["locomotion"]]
        assert main(["--json", "flash", str(PREDATOR), *words, "--verify"]) == 0
        for name, image in checked_images(PREDATOR).items():
            assert holds(bench, name, image)
    told = json.loads(capsys.readouterr().out)
    assert told["main"]["module"] == "BS2p24"
    assert told["locomotion"]["model"] == "BS2"
    for name, image in checked_images(PREDATOR).items():
        assert told[name]["verified_blocks"] == told[name]["blocks"] == len(plan_of(image).blocks)
        assert told[name]["image"] == image.digest


@pytest.mark.parametrize("kind", ["tcp:0", "pty"])
def test_a_port_whose_dtr_is_elsewhere(kind: str) -> None:
    image = read_image(PREDATOR, "locomotion")
    bench = bench_of_image(blank("BS2"))
    with serve(bench, kind) as server:
        name = f"{server.url}?control={server.control}"
        assert flash_image(name, image).attempts == 1
        assert holds(bench, "main", image)
        with pytest.raises(RigError, match=r"nobody takes its DTR and BREAK at 127\.0\.0\.1:1 "):
            identify_port(f"{server.url}?control=127.0.0.1:1")
        with pytest.raises(RigError, match="nobody takes its DTR and BREAK at nonsense "):
            identify_port(f"{server.url}?control=nonsense")


def test_the_ports_the_other_way_round(capsys: pytest.CaptureFixture[str]) -> None:
    with robot() as (bench, urls):
        words = ["--locomotion", urls["main"], "--main", urls["locomotion"]]
        assert main(["flash", str(PREDATOR), *words]) == 7
        assert not any(bench.chip(name).machine.memory.slots[0].frozen()[2047] for name in CHIPS)
    err = capsys.readouterr().err
    assert "nothing was sent: are the ports the other way round?" in err


def test_which_port_is_which_is_asked(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    sent: list[str] = []

    def flash(port: str, image: Image, **_: object) -> FlashReport:
        sent.append(f"{port} {image.model.name}")
        return FlashReport(port, identified[port], 0, (127,), 1, image.digest, True)

    with robot() as (_, urls):
        found = tuple(PortInfo(url, 0x0403, 0x6001) for url in sorted(urls.values()))
        identified = {url: identify_port(url) for url in urls.values()}
        monkeypatch.setattr(flashing, "all_ports", lambda: found)
        monkeypatch.setattr(flashing, "flash_image", flash)
        assert main(["flash", str(PREDATOR)]) == 0
    assert sent == [f"{urls['locomotion']} BS2", f"{urls['main']} BS2p"]
    assert f"main: BS2p24 on {urls['main']} has taken all 1 packets" in capsys.readouterr().out


def modules(**names: str) -> Identify:
    """What the ports of these names answer."""

    def identify(name: str, likely: tuple[Chip, ...]) -> Module:
        assert [model.name for model in likely] == ["BS2p", "BS2"]
        if names[name] == "none":
            raise RigError(f"{name}: nothing comes back")
        return Module(chip(names[name]), 24, "1.0")

    return identify


@pytest.mark.parametrize(
    ("names", "words"),
    [
        ({"a": "BS2"}, r"no port has the BS2p of the main controller \(a: BS2\); name both"),
        ({"a": "BS2p", "b": "none"}, r"no port has the BS2 of .*b: nothing comes back"),
        ({"a": "BS2p", "b": "BS2p", "c": "BS2"}, r"more than one port has the BS2p of the main"),
        ({}, r"no port has the BS2p of the main controller \(there is no USB adapter\)"),
    ],
)
def test_ports_that_do_not_fit_a_robot(names: dict[str, str], words: str) -> None:
    with pytest.raises(RigError, match=words):
        assign(checked_images(PREDATOR), {}, list(names), modules(**names))


def test_a_small_program_on_the_port_that_has_its_model(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "hello.bsp"
    path.write_text('\' {$STAMP BS2p}\nDEBUG "hello", CR\nEND\n', "utf-8")
    with robot() as (_, urls):
        found = tuple(PortInfo(url, 0x0403, 0x6001) for url in sorted(urls.values()))
        monkeypatch.setattr(ports_module, "all_ports", lambda: found)
        assert main(["flash", str(path)]) == 0
        assert main(["flash", "--identify-only", "--port", urls["main"]]) == 0
    out = capsys.readouterr().out
    assert f"hello: BS2p24 on {urls['main']} has taken all 2 packets" in out
    assert f"{urls['main']}: BS2p24, interpreter version 1.0" in out


def test_a_byte_that_is_not_what_was_sent_is_found() -> None:
    """Verifying reads the chip, not the image."""
    images = checked_images(PREDATOR)
    image = images["main"]
    bench = robot_bench(load_robot("servobot-predator"), images)
    bench.chip("main").machine.memory.write(0, 60, image.eeprom[60] ^ 1)
    flags = bytearray(2048)
    for block in (3, 4, 127):
        flags[16 * block : 16 * block + 16] = bytes((Use.DATA | SENT,)) * 16
    plan = plan_of(Image(image.model, image.eeprom, bytes(flags)))
    with serve(bench, "rfc2217:0") as server, pytest.raises(FlashError, match="byte 60 of the EEP"):
        read_back(server.url, plan)


def test_emulated_ports_need_nothing_at_all(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["--json", "flash", str(PREDATOR), "--port", "emu"]) == 0
    assert json.loads(capsys.readouterr().out)["main"]["blocks"] == len(
        packets_of(checked_images(PREDATOR)["main"])
    )
    path = tmp_path / "hello.bs2"
    path.write_text('\' {$STAMP BS2}\nDEBUG "hello", CR\nEND\n', "utf-8")
    assert main(["flash", str(path), "--port", "emu"]) == 0
    assert "hello: BS2 on rfc2217://" in capsys.readouterr().out


def test_a_source_of_several_slots(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The one that runs first goes in last, and finds the others there."""
    (tmp_path / "one.bsp").write_text("' {$STAMP BS2p, two.bsp}\nRUN 1\n", "utf-8")
    (tmp_path / "two.bsp").write_text('\' {$STAMP BS2p}\nDEBUG "two"\nEND\n', "utf-8")
    bench = bench_of_image(blank("BS2p"))
    words = ["flash", str(tmp_path / "one.bsp")]
    with serve(bench, "rfc2217:0") as server:
        assert main([*words, "--port", server.url]) == 0
    second, first = capsys.readouterr().out.splitlines()
    assert second.startswith("two.bsp: BS2p24 on ")
    assert "packets into slot 1, image" in second
    assert second.endswith("; slot 0 was started by a reset")
    assert first.startswith("one: ")
    assert first.endswith("; it talks")
    slots = bench.chip("main").machine.memory.slots
    assert any(slots[0].frozen())
    assert any(slots[1].frozen())
    assert main([*words, "--slot", "1", "--dry-run"]) == 2
    assert "leave --slot out" in capsys.readouterr().err
    (tmp_path / "two.bsp").write_text("' {$STAMP BS2}\nEND\n", "utf-8")
    assert main([*words, "--dry-run"]) == 3
    assert "two.bsp: is for a BS2, not for a BS2p" in capsys.readouterr().err


def test_what_went_in_before_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    def flash(port: str, image: Image, **_: object) -> FlashReport:
        if port == "a":
            return FlashReport(port, Module(image.model, 24, "1.0"), 0, (127,), 1, "", True)
        raise error

    monkeypatch.setattr(flashing, "flash_image", flash)
    image = blank("BS2")
    for error, words in (
        (RigError("b: lost; look at the cable"), "b: lost; look at the cable; legs went in before"),
        (KeyboardInterrupt(), "b: stopped; legs went in before"),
    ):
        with pytest.raises(FlashError, match=words):
            flashing.flash_in_turn({"legs": ("a", image), "head": ("b", image)})
        with pytest.raises(type(error)):
            flashing.flash_in_turn({"head": ("b", image), "legs": ("a", image)})


def test_a_chip_that_does_not_answer_afterwards_has_its_program_all_the_same(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Exit code 7 would say that nothing was sent."""

    def lost(*_: object) -> int:
        raise RigError("x: lost; look at the cable")

    monkeypatch.setattr(programmer_module, "read_back", lost)
    with (
        serve(bench_of_image(blank("BS2")), "rfc2217:0") as server,
        pytest.raises(FlashError, match="x: lost; look at the cable; every packet had been ackn"),
    ):
        flash_image(server.url, read_image(PREDATOR, "locomotion"), verify=True)


def test_ports_of_a_robot_by_their_serial_numbers(monkeypatch: pytest.MonkeyPatch) -> None:
    found = (PortInfo("/dev/a", 1, 2, "A1"), PortInfo("/dev/b", 1, 2, "B2"))
    monkeypatch.setattr(ports_module, "all_ports", lambda: found)
    models = {"/dev/a": "BS2p", "/dev/b": "BS2"}

    def identify(name: str, likely: tuple[Chip, ...]) -> Module:
        return Module(chip(models[name]), 24, "1.0")

    named = {"main": "id:A1", "locomotion": "id:B2"}
    images = checked_images(PREDATOR)
    assert assign(images, named, None, identify) == {"main": "/dev/a", "locomotion": "/dev/b"}
    with pytest.raises(RigError, match="/dev/a: cannot be both chips"):
        assign(images, {"main": "id:A1", "locomotion": "/dev/a"}, None, identify)


def test_a_port_that_is_taken_by_another_session() -> None:
    with serve(bench_of_image(blank("BS2")), "rfc2217:0") as server:
        with (
            programmer_module.opened(server.url),
            pytest.raises(RigError, match="another session of cgagen has this port"),
        ):
            identify_port(server.url)
        assert identify_port(server.url).name == "BS2"


def test_a_port_that_another_program_reads() -> None:
    """It has not locked it, and would eat half of the answers."""
    master, slave = pty.openpty()
    name = os.ttyname(slave)
    with opened_by_another(name, "open(sys.argv[1])") as number:
        with pytest.raises(RigError, match=rf"another program has it open .*process {number}"):
            identify_port(name)
    with pytest.raises(RigError, match="has no DTR or no BREAK"):
        identify_port(name)
    os.close(master)
    os.close(slave)


@pytest.mark.parametrize("kind", ["rfc2217:0", "tcp:0"])
def test_a_server_that_goes_away_in_the_middle(kind: str) -> None:
    server: Server
    with serve(bench_of_image(blank("BS2")), kind) as server:
        control = f"?control={server.control}" if server.control else ""

        def pull(progress: object) -> None:
            server.endpoints[0].lose()

        with pytest.raises(FlashError, match="half a program"):
            flash_image(f"{server.url}{control}", read_image(PREDATOR, "locomotion"), progress=pull)


def test_a_socket_without_dtr_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["flash", "--identify-only", "--port", "socket://127.0.0.1:1"]) == 7
    assert "carries neither BREAK nor DTR" in capsys.readouterr().err


def test_a_dry_run_says_exactly_the_marked_blocks(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--json", "flash", str(PREDATOR), "--dry-run"]) == 0
    told = json.loads(capsys.readouterr().out)
    record = json.loads((PREDATOR / "build.json").read_text("utf-8"))
    for name in CHIPS:
        words = record["programs"][name]["blocks"]
        marked = [number for number, word in enumerate(words) if word.startswith("+")]
        assert told[name]["blocks"] == marked
        assert all(sum(bytes.fromhex(packet)) % 256 == 0 for packet in told[name]["packets"])


def test_a_name_that_is_misspelt(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["flash", "runs/demo/biuld"]) == 3
    assert "biuld: cannot be read (No such file" in capsys.readouterr().err
