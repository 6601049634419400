"""`cgagen emulate BENCH`: what it says of the parts, wires and faults of a bench file."""

import json

import pytest

from tests.emulate_cases import BASIC, Emulate, Program

SONAR = (
    BASIC + "n VAR Byte\nw VAR Word\nFOR n = 1 TO 3\n  LOW 4\n  PULSOUT 4, 5\n  PULSIN 4, 1, w\n"
    "  DEBUG DEC w, CR\n  PULSOUT 12, 1000\n  PAUSE 100\nNEXT\nEND\n"
)
BENCH = """format = "cgagen-bench-1"
[chip.main]
source = "it.bs2"
[wire.sonar]
ends = ["main.P4", "front.signal"]
[wire.leg]
ends = ["main.P12", "servo.signal", "probe.signal"]
[wire.text]
ends = ["main.SOUT", "peer.receive"]
[part.front]
kind = "ping"
echo_us = 2001
[part.servo]
kind = "servo"
[part.probe]
kind = "probe"
[part.peer]
kind = "uart"
inverted = true
"""
SILENCE = '[fault.silence]\nkind = "no_echo"\npart = "front"\nfrom_ms = 100\n'


def test_faults_say_whether_they_fired(emulate: Emulate, program: Program) -> None:
    program(SONAR)
    never = '[fault.never]\nkind = "stuck"\nend = "main.P4"\nlevel = 1\nfrom_ms = 60_000\n'
    code, out, err = emulate(program(BENCH + SILENCE + never, "it.toml"))
    assert (code, out) == (0, "1000\r0\r0\r")
    first, second = err.splitlines()
    assert first.startswith("note: fault silence: made a difference 2 times, first at 0.1")
    assert second == "note: fault never: made no difference in this run"


def test_a_fault_that_ends_the_run_is_named(emulate: Emulate, program: Program) -> None:
    program(BASIC + "HIGH 1\nLOW 2\nPAUSE 1000\nEND\n")
    bench = (
        'format = "cgagen-bench-1"\n[chip.main]\nsource = "it.bs2"\n[wire.a]\nends = ["main.P1"]\n'
        '[wire.b]\nends = ["main.P2"]\n'
        '[fault.touch]\nkind = "bridge"\nwires = ["a", "b"]\nfrom_ms = 50\n'
    )
    code, _, err = emulate(program(bench, "it.toml"))
    assert code == 3
    assert "note: fault touch: made a difference once at 0.050000 s\n" in err
    assert "it.bs2:5: a: main.P1 drives 1, main.P2 drives 0" in err


def test_a_chip_without_supply_is_no_endless_run(emulate: Emulate, program: Program) -> None:
    program(BASIC + 'DEBUG "a"\nPAUSE 1000\nDEBUG "b"\nEND\n')
    bench = (
        'format = "cgagen-bench-1"\n[chip.main]\nsource = "it.bs2"\n'
        '[fault.off]\nkind = "brown_out"\nchips = ["main"]\nfrom_ms = 50\n'
    )
    code, out, err = emulate(program(bench, "it.toml"), "--until-end", "--expect-end")
    assert (code, out) == (9, "a")
    assert "fault off: made a difference once at 0.050000 s" in err
    code, out, _ = emulate(program(bench + "until_ms = 90\n", "it.toml"), "--until-end")
    assert (code, out) == (0, "aab")


def test_json_has_what_parts_have_seen(emulate: Emulate, program: Program) -> None:
    program(SONAR)
    code, out, _ = emulate(program(BENCH + SILENCE, "it.toml"), "--json", "--pin", "9=1")
    parts = json.loads(out)["parts"]
    assert code == 0
    assert parts.keys() == {"front", "servo", "probe", "peer", "silence"}
    assert parts["front"] == {"triggers": 3, "ignored": 0}
    assert parts["probe"] == {"edges": 7}  # the pin becomes an output first
    assert parts["peer"] == {"sent": 0, "received": "1000\r0\r0\r", "errors": 0}
    servo = parts["servo"]
    assert (servo["pulses"], servo["shortest_ns"], servo["longest_ns"]) == (3, 2_000_000, 2_000_000)
    assert (servo["angle_deg"], servo["odd"]) == (pytest.approx(45, abs=6), 0)
    assert parts["silence"]["fired"] == 2
    assert 100_000_000 < parts["silence"]["first_ns"] < 200_000_000


def test_a_slot_without_a_program(emulate: Emulate, program: Program) -> None:
    stamp = "' {$STAMP BS2p}\n' {$PBASIC 2.5}\n"
    code, out, err = emulate(program(stamp + 'DEBUG "a"\nRUN 3\n', "it.bsp"))
    assert (code, out) == (0, "a")
    assert "slot 3 of main holds no program, and the chip has come to it" in err


def test_a_pin_that_floats_on_a_wire(emulate: Emulate, program: Program) -> None:
    program(BASIC + "DEBUG BIN1 IN7\n")
    bench = (
        'format = "cgagen-bench-1"\n[chip.main]\nsource = "it.bs2"\n[wire.door]\nends = ["main.P7"]'
    )
    code, out, err = emulate(program(bench, "it.toml"))
    assert (code, out) == (0, "0")
    assert (
        "it.bs2:3: P7 on the wire door is read, and nothing drives it: it reads 0 (--pin 7=1 "
        in err
    )
    code, out, err = emulate(program(bench + '\npull = "up"\n', "it.toml"))
    assert (code, out, err) == (0, "1", "")


TWO = """format = "cgagen-bench-1"
[chip.main]
source = "it.bs2"
[chip.other]
source = "other.bs2"
[wire.w]
ends = ["main.P1", "other.P1"]
"""


def test_a_short_circuit_is_located_where_it_began(emulate: Emulate, program: Program) -> None:
    program(BASIC + "HIGH 1\nPAUSE 100\n")
    program(BASIC + "PAUSE 50\nLOW 1\n", "other.bs2")
    code, _, err = emulate(program(TWO, "it.toml"))
    assert code == 3
    assert "other.bs2:4: w: other.P1 drives 0, main.P1 drives 1" in err


def test_the_hint_for_another_chip_names_it(emulate: Emulate, program: Program) -> None:
    program(BASIC + "PAUSE 100\n")
    program(BASIC + "IF IN9 = 1 THEN HIGH 1\n", "other.bs2")
    code, _, err = emulate(program(TWO, "it.toml"))
    assert code == 0
    assert "other.bs2:3: P9 is read, and nothing is wired to it: it reads 0 (--pin other.P9=" in err


def test_a_pin_is_held_once(emulate: Emulate, program: Program) -> None:
    code, _, err = emulate(program(BASIC + "END\n"), "--pin", "7=1", "--pin", "P7=0")
    assert code == 2
    assert "--pin P7=0: main.P7 is held already" in err
