"""Which options of a verb do not go together, as data; looked at before a verb does anything.

Every option of every verb is either in `FREE`, for it says something whatever else is given, or in
a rule. What depends on the kind of a file, or on what is in it, is refused by the verb itself,
and what names a thing twice (a genome beside a build, a robot beside a banner) is held together.
"""

import os

import click
from click.core import ParameterSource

from cgagen.together import Apart, Needs, Rule, Together, among, apart, trouble

_EMULATED_ENDS = (
    "--emulated ends with the capture, after which the simulator holds both robots and "
    "the firmware does not; leave out --past-capture"
)
_IN_FIRMWARE = (
    "{first} and {second}: %s is in the firmware, which is built from the robot's file; change "
    "it there and pass the file"
)
_OF_READINGS = (
    "{first} and {second} exclude each other: a reading that is named is tried alone; leave one out"
)
_BOTH = "{first} and {second}: both say which readings; give one of them"
_EPISODE = "{second} is of an episode, and {first} is none; leave one out"
_DECIDES = "{first} listens to a robot that decides by itself; leave out {second}"
_NO_PROGRAM = "{first} and {second}: the simulator asks no program; name another --target"

_BYTES = "{first} is bytes, and {second} a line of JSON for each line; leave one out"
_TIMED = "{second} and {first}: a line of JSON is no line of text; leave one out"

_WAYS = ("--level", "--from", "--sweep", "--port")
_AFTER = ("--hold", "--go-on")
_OPEN = ("--masking", "--no-masking", "--light", "--prey-policy", "--walls")
_PLAYERS = ("--opponent", "--arena")

ANYWHERE = ""

RULES: dict[str, tuple[Rule, ...]] = {
    ANYWHERE: (Apart("--quiet", "--verbose"),),
    "simulate": (
        Needs("--build", ("--emulated",)),
        Needs("--no-referee", ("--emulated",)),
        Apart("--emulated", "--past-capture", _EMULATED_ENDS),
        *apart(["--emulated"], ["--masking", "--no-masking"], _IN_FIRMWARE % "masking"),
        Apart("--emulated", "--light", _IN_FIRMWARE % "light"),
        Apart("--emulated", "--prey-policy", _IN_FIRMWARE % "prey policy"),
        Needs("--hold", ("--past-capture",)),
        Needs("--go-on", ("--past-capture",)),
    ),
    "verify": (
        *apart(["--reading"], ["--level", "--seed"], _OF_READINGS),
        Needs("--kills", ("--report",)),
    ),
    "emulate": (
        Apart("--for", "--until-end"),
        *apart(["--port"], ["--input", "--until-end", "--echo", "--expect-end", "--durations"]),
        Needs("--atn", ("--port",)),
    ),
    "flash": (
        *apart(
            ["--identify-only"],
            [
                "TARGET", "--verify", "--dry-run", "--main", "--locomotion", "--model", "--slot",
                "--port emu",
            ],
            "--identify-only takes a real --port and nothing else; leave out {second}",
        ),
        Apart("--dry-run", "--verify"),
        *apart(["--port emu"], ["--main", "--locomotion"]),
    ),
    "monitor": (
        Needs("--robot", ("--decode",)),
        *apart(["--raw"], ["--decode", "--timestamps"]),
        Apart("--raw", "--json", _BYTES),
        Apart("--json", "--timestamps", _TIMED),
    ),
    "robot sensors": (Together(("--sensor", "--distance", "--table")),),
    "trace record": (
        *among(_WAYS, _BOTH),
        *apart(
            _WAYS,
            ["--predator", "--prey", "--steps", "--of", *_AFTER, *_OPEN, *_PLAYERS],
            _EPISODE,
        ),
        *apart(["--port"], ["--target", "--build"], _DECIDES),
        Needs("--build", ("--target",)),
        Apart("--build", "--target simulator", _NO_PROGRAM),
        Needs("--readings", ("--port",)),
        Needs("--for", ("--port",)),
        Needs("--seed", ("--level",)),
    ),
    "calibrate": (
        Needs("--opponent", ("--genome",)),
        Needs("--date", ("--output",)),
    ),
}  # fmt: skip
"""By what a user types behind `cgagen`; "" for what may stand anywhere."""

_WORLD = (*_AFTER, *_OPEN, *_PLAYERS)

FREE: dict[str, tuple[str, ...]] = {
    ANYWHERE: ("--json", "--no-progress", "--no-color", "--version"),
    "setup": ("--offline", "--force"),
    "doctor": ("--identify",),
    "evolve": (
        "--robot", "--generations", "--population", "--seed", "--trials", "--first-trial",
        "--workers", "--run", "--mutation", "--elite", "--starts", "--steps", "--fixed-starts",
        "--fixed-starts-seed", "--evaluate-every", *_WORLD,
    ),
    "resume": ("RUN", "--workers"),
    "simulate": (
        "GENOME", "--predator", "--prey", "--steps", "--robot", "--walls", *_PLAYERS,
    ),
    "build": ("GENOME", "--robot", "--output", "--templates", "--force"),
    "verify": ("GENOME", "--robot", "--build", "--target", "--legs", "--trace", "--force"),
    "compile": ("FILE", "--output", "--map", "--force"),
    "emulate": (
        "FILE", "--model", "--chip", "--pin", "--baud", "--json", "--realtime", "--vcd", "--trace",
        "--coverage", "--force",
    ),
    "ports": ("--identify",),
    "monitor": ("--port", "--baud", "--input", "--for", "--reset", "--log", "--force"),
    "robot centre": ("--port", "--reset"),
    "robot move": ("MOVEMENT", "--cycles", "--port", "--reset", "--robot"),
    "robot sensors": ("--port", "--reset", "--robot", "--readings"),
    "calibrate": ("TABLES", "--robot", "--arena", "--force"),
    "trace record": ("GENOME", "--output", "--robot", "--force"),
    "trace convert": ("SOURCE", "OUTPUT", "--robot", "--readings-only", "--force"),
    "trace show": ("FILE", "--robot"),
    "info": ("FILE", "--robot", "--model", *_WORLD),
    "benchmark": (),
}  # fmt: skip
"""Options that say something whatever else is given; those of `info` go by the kind of its file.

`--force` is here: it allows, and claims nothing where there is nothing to overwrite.
"""

OUTPUTS: dict[str, tuple[str, ...]] = {
    "emulate": ("--vcd", "--trace", "--coverage"),
    "compile": ("FILE", "--output", "--map"),
}
"""Files of which no two may be one: the later would take the place of the earlier."""


def check_options(context: click.Context) -> None:
    """Refuse options that do not go together.

    Raises:
        click.UsageError: the first rule that is broken.
    """
    path = path_of(context)
    rules = (*RULES[ANYWHERE], *RULES.get(path, ()))
    words = trouble(rules, given_in(context)) or _one_file(context, OUTPUTS.get(path, ()))
    if words:
        raise click.UsageError(words, context)


def _one_file(context: click.Context, names: tuple[str, ...]) -> str:
    """Return the sentence about two files that are one; devices and pipes take all that comes."""
    seen = dict[str, str]()
    for one in context.command.params:
        path = context.params.get(one.name or "")
        name = name_of(one)
        if name not in names or path is None or (os.path.exists(path) and not os.path.isfile(path)):
            continue
        place = os.path.realpath(path)
        if place in seen:
            return f"{seen[place]} and {name}: both are {path}; choose another name for one of them"
        seen[place] = name
    return ""


def path_of(context: click.Context) -> str:
    """Return what a user types behind `cgagen` for a command, such as `trace record`."""
    names = list[str]()
    here: click.Context | None = context
    while here is not None and here.parent is not None:
        names.insert(0, here.info_name or "")
        here = here.parent
    return " ".join(names)


def given_in(context: click.Context) -> set[str]:
    """Return the options and arguments that were typed, each also with its value where it has one.

    What is there by default is not given: nobody has asked for it.
    """
    given = set[str]()
    for one in context.command.params:
        source = context.get_parameter_source(one.name or "")
        if source not in (ParameterSource.COMMANDLINE, ParameterSource.ENVIRONMENT):
            continue
        value = context.params.get(one.name or "", True)
        name = name_of(one, value is False)
        given |= {name} | ({f"{name} {value}"} if isinstance(value, str) else set())
    said = {"as_json": "--json", "quiet": "--quiet", "verbose": "--verbose"}
    return given | {name for key, name in said.items() if getattr(context.obj, key, False)}


def name_of(parameter: click.Parameter, off: bool = False) -> str:
    """Return what a user calls a parameter: the long name of an option, an argument in capitals.

    Args:
        parameter: of a command.
        off: the name that switches it off, where it has one.
    """
    if isinstance(parameter, click.Argument):
        return (parameter.name or "").upper()
    names = parameter.secondary_opts if off and parameter.secondary_opts else parameter.opts
    return max(names, key=len)
