"""The table of verbs, in the order of the house. Each verb's code is imported when it is called.

A verb parses its words, calls one function of the library and prints its result: results on
stdout, progress and notes on stderr. Whatever goes wrong is one sentence and an exit code
(`cgagen.errors`); a traceback is a bug of ours, shown in full only with `-v`.
"""

import importlib
import sys
from typing import Any

import click

from cgagen import __version__
from cgagen.signals import Asked, signals_end
from cgagen.verbs.console import Console
from cgagen.verbs.ending import end, ended, flush, remove_own_temporaries
from cgagen.verbs.words import Verbs, with_anywhere

VERBS: dict[str, tuple[str, str]] = {
    #  verb       module in cgagen.verbs, what `--help` says
    "setup": ("toolchain", "Fetch Parallax's tokenizer, once, with its hash checked."),
    "doctor": ("toolchain", "Say what is missing on this machine and how to mend it."),
    "evolve": ("evolve", "Evolve a genome into a run folder."),
    "resume": ("evolve", "Continue a run after any interruption, bit for bit."),
    "simulate": ("simulate", "Play one episode, a line per step."),
    "build": ("build", "Write and compile the programs of both Stamps."),
    "verify": ("verify", "Compare the programs of both Stamps with the simulator."),
    "compile": ("compile", "Compile any PBASIC source to an EEPROM image."),
    "emulate": ("emulate", "Run any PBASIC program on an emulated Stamp."),
    "ports": ("ports", "List serial ports, and what hangs on them."),
    "flash": ("flash", "Program real Stamps: a build into both, or an image into one."),
    "monitor": ("monitor", "Listen to a Stamp, and type to it."),
    "robot": ("robot", "Centre a robot's servos, walk a movement, read its sensors."),
    "calibrate": ("calibrate", "Turn measurements of a robot into its file."),
    "trace": ("trace", "Record, convert or show what a robot has sensed."),
    "info": ("info", "Describe a genome, run, robot, build, image or trace."),
    "benchmark": ("benchmark", "Measure speed on this machine, as rates and ratios."),
}


class LazyGroup(Verbs):
    """A group that lists its verbs from the table and imports one only to run it."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the verbs in the order of the table."""
        return list(VERBS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import the verb that was asked for, and no other."""
        if cmd_name not in VERBS:
            return None
        module = importlib.import_module(f"cgagen.verbs.{VERBS[cmd_name][0]}")
        command = getattr(module, f"{cmd_name}_verb")
        if not isinstance(command, click.Command):
            raise TypeError(f"{module.__name__}.{cmd_name}_verb is not a command")
        # A docstring with a backslash is raw, so click's mark for "leave these lines" is, too.
        command.help = (command.help or "").replace(r"\b", "\b")
        return with_anywhere(command)

    def make_context(
        self,
        info_name: str | None,
        args: list[str],
        parent: click.Context | None = None,
        **extra: Any,
    ) -> click.Context:
        """Begin a call; who calls from Python without a console has that of the process."""
        extra.setdefault("obj", Console.of_process())
        return super().make_context(info_name, args, parent, **extra)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the verbs without importing them."""
        with formatter.section("Verbs"):
            formatter.write_dl([(verb, help_text) for verb, (_, help_text) in VERBS.items()])


@click.group(cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, message="cgagen %(version)s")
def cgagen() -> None:
    """From an evolved genome to proven firmware for both Stamps of a hexapod.

    The options below may stand before a verb or behind it. `cgagen VERB --help` has a verb's own.
    """


with_anywhere(cgagen, all_shown=True)


def main(arguments: list[str] | None = None) -> int:
    """Run one verb and return its exit code; never raise.

    Args:
        arguments: the words after `cgagen`; None for those of this process.

    >>> main(["--version"])
    cgagen 0.1.0
    0
    """
    words = sys.argv[1:] if arguments is None else arguments
    asked = Asked()
    with signals_end(asked):
        try:
            result = cgagen.main(
                args=words,
                prog_name="cgagen",
                standalone_mode=False,
                obj=Console.of_process(),
            )
            flush()
            return ended(result if isinstance(result, int) else 0, asked)
        except BaseException as error:
            return end(error, words, asked)
        finally:
            remove_own_temporaries()
