"""Words of a command line: options that stand anywhere, and what a mistyped word was to be."""

import json
from collections.abc import Callable

import click
import pytest

from cgagen.cli import VERBS, cgagen, main
from cgagen.verbs.words import ANYWHERE, NESTED, Words
from tests.subjects import FIRMWARE

MAIN = str(FIRMWARE / "predator" / "main.bin")
GENOME = str(FIRMWARE / "reference.genome")
Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    def call(*words: str) -> tuple[int, str, str]:
        code = main(list(words))
        out = capsys.readouterr()
        return code, out.out, out.err

    return call


def commands() -> list[tuple[str, click.Command]]:
    """Return every verb, and every verb of a verb, by what is typed."""
    context = click.Context(cgagen)
    found = []
    for name in VERBS:
        command = cgagen.get_command(context, name)  # type: ignore[attr-defined]
        found.append((name, command))
        if isinstance(command, click.Group):
            found += [(f"{name} {key}", one) for key, one in command.commands.items()]
    return found


@pytest.mark.parametrize(("name", "command"), commands(), ids=str)
def test_every_verb_takes_the_options_that_stand_anywhere(
    name: str, command: click.Command
) -> None:
    taken = [opt for one in command.params for opt in one.opts]
    assert len(taken) == len(set(taken))
    assert {opt for names, _, _ in ANYWHERE for opt in names} <= set(taken)


@pytest.mark.parametrize("name", NESTED)
def test_verbs_of_verbs_are_there(name: str) -> None:
    assert NESTED[name] in dict(commands())


def test_json_stands_anywhere(run: Run) -> None:
    for words in ("--json info {}", "info --json {}", "info {} --json"):
        assert json.loads(run(*words.format(GENOME).split())[1])["kind"] == "genome"
    for place in (0, 1, 2, 3, 5):
        line = f"trace record {GENOME} -o /dev/null/none.log".split()
        line.insert(place, "--json")
        code, _, err = run(*line)
        assert (code, "No such option" in err) == (3, False)


def test_quiet_stands_anywhere_and_is_quiet(run: Run) -> None:
    """The reference has changed since its genome evolved, which is told in a note."""
    words = ["simulate", GENOME, "--steps", "1"]
    assert run(*words)[2].startswith("note: ")
    for quiet in (["-q", *words], [*words, "-q"], [words[0], "--quiet", *words[1:]]):
        code, out, err = run(*quiet)
        assert (code, err, out.startswith("step")) == (0, "", True)


def test_a_value_is_no_option(run: Run) -> None:
    """What an option takes may look like one of ours."""
    code, _, err = run("verify", GENOME, "--reading", "-q")
    assert code == 2
    assert "--reading: '-q'" in err


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["evolv"], 2, "no such verb: evolv (did you mean evolve?)"),
        (["xyz"], 2, "no such verb: xyz; there are setup, doctor, evolve"),
        (["move", "FORWARD"], 2, "no such verb: move (did you mean robot move?)"),
        (["robot", "cetre"], 2, "no such verb: cetre (did you mean centre?)"),
        (["trace", "xyz"], 2, "no such verb: xyz; there are record, convert, show"),
        ([GENOME], 2, f"to be told what that file is, say: cgagen info {GENOME}"),
        (["--seed", "3", "evolve"], 2, "'--seed'; a verb's options stand behind it"),
        (["robot", "--port", "x", "move"], 2, "'--port'; a verb's options stand behind it"),
        (["evolve", "--sead", "3"], 2, "--seed"),
        (["verify", GENOME, "--level", "exhaustiv"], 2, "(did you mean exhaustive?)"),
        (["trace", "record", GENOME, "-o", "x.log", "--of", "pray"], 2, "(did you mean prey?)"),
        (["robot", "move", "FORWRD"], 2, "(did you mean FORWARD?)"),
        (["simulate", GENOME, "--walls", "slid"], 2, "(did you mean slide?)"),
        (["emulate", "x.bs2", "--atn", "capacitr"], 2, "(did you mean capacitor?)"),
        (["build", "--robot", "servobot-pray"], 3, "(did you mean servobot-prey?)"),
        (["simulate", GENOME, "--arena", "colonie"], 3, "(did you mean colony?)"),
        (["verify", GENOME, "--target", "serail:x"], 2, "(did you mean serial?)"),
        (["info", MAIN, "--model", "BS2px"], 3, "did you mean BS2p"),
    ],
)
def test_a_mistyped_word_is_told_what_it_was_to_be(
    run: Run, words: list[str], code: int, said: str
) -> None:
    got, out, err = run(*words)
    assert (got, out) == (code, "")
    assert said in err


def test_a_choice_far_from_all_has_no_hint(run: Run) -> None:
    code, _, err = run("verify", GENOME, "--level", "zzz")
    assert (code, "did you mean" in err) == (2, False)
    assert Words(["a"]).convert("a", None, None) == "a"
