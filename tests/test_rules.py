"""Options that do not go together: every option of every verb is ruled, and every rule holds."""

import re
from collections.abc import Iterator
from pathlib import Path

import click
import pytest

from cgagen.cli import VERBS, cgagen, main
from cgagen.together import Apart, Needs, Rule, Together, trouble
from cgagen.verbs.console import Console
from cgagen.verbs.rules import FREE, OUTPUTS, RULES, check_options, name_of
from tests.subjects import FIRMWARE

GENOME = str(FIRMWARE / "reference.genome")
ARGUMENTS = {
    "simulate": [GENOME],
    "emulate": ["x.bs2"],
    "trace record": [GENOME, "-o", "x.log"],
    "calibrate": ["x.csv", "--robot", "servobot-prey"],
    "compile": ["x.bs2"],
}
"""What a verb wants in any case. None of these files is opened before the options are looked at."""


def commands() -> Iterator[tuple[str, click.Command]]:
    """Every command behind `cgagen`, and what is typed for it."""
    context = click.Context(cgagen)
    for verb in VERBS:
        command = cgagen.get_command(context, verb)
        assert command is not None
        if isinstance(command, click.Group):
            yield from ((f"{verb} {name}", one) for name, one in command.commands.items())
        else:
            yield verb, command
    yield "", cgagen


COMMANDS = dict(commands())


def names_of(path: str) -> set[str]:
    """What is typed for a command's own parameters; what may stand anywhere is the group's."""
    params = COMMANDS[path].params
    if path:
        params = [one for one in params if not (one.name or "").startswith("anywhere_")]
    switched = [one for one in params if one.secondary_opts]
    return {*map(name_of, params), *(name_of(one, off=True) for one in switched)}


@pytest.mark.parametrize("path", COMMANDS)
def test_every_option_is_free_or_in_a_rule_and_none_is_invented(path: str) -> None:
    ruled = {word.split(" ")[0] for rule in RULES.get(path, ()) for word in rule.options}
    known, listed = names_of(path), {*FREE.get(path, ()), *ruled}
    assert known - listed == set(), "say in cgagen/verbs/rules.py what goes with these"
    assert listed - known - names_of("") == set(), "there are no such options"


def test_rules_are_of_verbs_that_there_are() -> None:
    assert set(RULES) | set(FREE) | set(OUTPUTS) <= set(COMMANDS)


def typed(path: str, word: str, folder: Path) -> list[str]:
    """The words for an option, with a value that it takes."""
    name, _, value = word.partition(" ")
    command = COMMANDS[path]
    one = next(p for p in command.params if name in {name_of(p), name_of(p, off=True)})
    if isinstance(one, click.Argument):
        return [value or "x"]
    if isinstance(one, click.Option) and (one.is_flag or one.secondary_opts):
        return [name]
    if not value:
        kinds = {
            click.Choice: lambda kind: kind.choices[0],
            click.IntRange: lambda kind: str(max(kind.min or 1, 1)),
            click.FloatRange: lambda _: "1",
            click.Path: lambda kind: str(folder if not kind.dir_okay or kind.exists else "x"),
        }
        made = next((make for kind, make in kinds.items() if isinstance(one.type, kind)), None)
        value = (
            made(one.type) if made else {"X,Y,DEG": "1,2,3", "TIME": "1s"}.get(one.type.name, "1")
        )
        if isinstance(one.type, click.Path) and not one.type.dir_okay:
            value = str(folder / "file")
    return [name, value]


def refusal(path: str, words: list[str]) -> str:
    """What is said of words behind a command; nothing of it is run."""
    above, name = ["cgagen", *path.split()[:-1]], path.rpartition(" ")[2] or "cgagen"
    parent = None
    for one in above if path else []:
        parent = click.Context(cgagen, parent=parent, info_name=one)
    with COMMANDS[path].make_context(name, words, parent=parent, obj=Console()) as made:
        with pytest.raises(click.UsageError) as caught:
            check_options(made)
    return caught.value.message


CASES = [(path, rule) for path, rules in RULES.items() for rule in rules]


@pytest.mark.parametrize(("path", "rule"), CASES, ids=[f"{p} {r.options}" for p, r in CASES])
def test_a_rule_is_a_usage_error_that_names_both(path: str, rule: Rule, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    wrong = rule.options[:2] if isinstance(rule, Apart) else rule.options[:1]
    before = RULES[path][: RULES[path].index(rule)]
    needed = [
        one.others[0]
        for one in before
        if isinstance(one, Needs) and one.option in wrong and one.others[0] not in str(wrong)
    ]
    words = [part for word in (*wrong, *needed) for part in typed(path, word, tmp_path)]
    if path == "":
        words = [*words, "ports"]
    said = refusal(path, [*ARGUMENTS.get(path, []), *words])
    assert trouble([rule], set(wrong)) == said
    named = wrong if isinstance(rule, Apart) else rule.options[:2]
    assert [word for word in named if word not in said] == [], said


@pytest.mark.parametrize(("path", "rule"), CASES, ids=[f"{p} {r.options}" for p, r in CASES])
def test_a_rule_refuses_nothing_else(path: str, rule: Rule) -> None:
    fine: list[set[str]] = [set(), {"--other"}]
    if isinstance(rule, Apart):
        fine += [{rule.first}, {rule.second}]
    elif isinstance(rule, Needs):
        fine += [{rule.option, other} for other in rule.others] + [{*rule.others}]
    else:
        fine += [{*rule.options}]
    assert [given for given in fine if trouble([rule], given)] == []


@pytest.mark.parametrize(
    "words",
    [
        ["-q", "-v", "doctor"],
        ["emulate", "none.bs2", "--for", "1s", "--until-end"],
        ["trace", "record", GENOME, "-o", "x.log", "--sweep", "--port", "/dev/no"],
        ["verify", "none.genome", "--seed", "2", "--reading", "0,0,0/--/0,0"],
    ],
)
def test_the_rules_are_looked_at_by_every_verb(
    words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(words) == 2
    assert re.search(r"exclude each other|both say", capsys.readouterr().err)


def test_things_that_belong_together_are_all_there_or_none() -> None:
    rule = Together(("--a", "--b", "--c"))
    assert trouble([rule], {"--a", "--c"}) == "--a, --b and --c belong together; give all of them"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["emulate", "x.bs2", "--vcd", "a", "--trace", "./a"], "--vcd and --trace: both are"),
        (["emulate", "x.bs2", "--trace", "a", "--coverage", "a"], "--trace and --coverage: both"),
        (["compile", "x.bs2", "-o", "a", "--map", "a"], "--output and --map: both are a"),
        (["compile", "x.bs2", "-o", "x.bs2"], "FILE and --output: both are x.bs2"),
    ],
)
def test_two_outputs_are_two_files(
    words: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(words) == 2
    assert said in capsys.readouterr().err


def test_what_nobody_has_typed_breaks_no_rule(capsys: pytest.CaptureFixture[str]) -> None:
    """Defaults are not given: a level beside a reading is there in every call."""
    words = ["--build", str(FIRMWARE / "predator"), "--reading", "0,0,0/--/0,0"]
    assert main(["verify", *words]) == 11  # all but that reading was not tried
    assert "emulator          PASS" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("file", "option"),
    [
        (FIRMWARE / "predator", "--model"),
        (FIRMWARE / "predator" / "robot.toml", "--robot"),
        (FIRMWARE / "predator" / "main.bin", "--no-masking"),
        (FIRMWARE / "reference.genome", "--model"),
        (FIRMWARE.parent / "hil" / "traces" / "hunt.log", "--opponent"),
        (FIRMWARE / "prey", "--light"),
    ],
)
def test_info_refuses_what_says_nothing_about_a_file(
    file: Path, option: str, capsys: pytest.CaptureFixture[str]
) -> None:
    value = {"--light": ["dark"], "--no-masking": []}.get(option, ["servobot-prey"])
    assert main(["info", str(file), option, *value]) == 2
    assert f"{option} says nothing about a" in capsys.readouterr().err
