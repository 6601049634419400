"""`cgagen setup` and `cgagen doctor`: the tools that compile PBASIC, and the ports."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from cgagen.verbs.console import Console, with_console
from cgagen.verbs.environment import TOOLCHAIN

if TYPE_CHECKING:
    from cgagen.tokenizer.doctor import Check


@click.command("setup", epilog=TOOLCHAIN)
@click.option(
    "--offline",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE",
    help="Take it from a tarball of `npm pack pbasic-tokenizer@0.3.0`, or from its index.js.",
)
@click.option("--force", is_flag=True, help="Fetch it again even if it is there.")
@with_console
def setup_verb(console: Console, offline: Path | None, force: bool) -> None:
    """Fetch Parallax's tokenizer into the user's cache, once, with its hash checked.

    It comes from npm as pbasic-tokenizer 0.3.0 (MIT, Parallax Inc.), by a lock file that cgagen
    carries. Node 18 or later is needed, from PATH or from `pip install 'cgagen[node]'`.

    npm's own settings (proxy, registry) hold as usual.
    """
    from cgagen.toolchain import TOKENIZER_SHA256, setup

    path, fetched = setup(offline, force)
    data = {"tokenizer": str(path), "sha256": TOKENIZER_SHA256, "fetched": fetched}
    console.result(data, f"tokenizer: {path} ({'now' if fetched else 'already'} there)")


@click.command("doctor", epilog=TOOLCHAIN)
@click.option("--identify", is_flag=True, help="Reset what hangs on the ports, and ask who it is.")
@with_console
@click.pass_context
def doctor_verb(context: click.Context, console: Console, identify: bool) -> None:
    """Say line by line what this machine has, what is missing, and how to mend it.

    Serial ports are looked at and not opened, so nothing is reset; with --identify they are, and
    what is wrong with cable, adapter and Stamp is told. Exit code 4 if something is missing
    without which nothing compiles.
    """
    from dataclasses import asdict

    from cgagen.errors import ToolchainError
    from cgagen.tokenizer.doctor import examine

    checks = (*examine(), *_ports(identify))
    healthy = all(check.ok for check in checks if check.needed)
    console.result(
        {"ok": healthy, "checks": [asdict(check) for check in checks]},
        "\n".join(check.to_text() for check in checks),
    )
    context.exit(0 if healthy else ToolchainError.exit_code)


def _ports(identify: bool) -> "list[Check]":
    """Return a check for each serial port; no compile needs one."""
    from cgagen.link.condition import all_conditions
    from cgagen.link.ports import NONE
    from cgagen.tokenizer.doctor import Check
    from cgagen.verbs.ports import ask

    found = []
    for one in all_conditions():
        module, says = ask(one) if identify else (None, one.says)
        ok = module is not None if identify else one.ok
        found.append(Check(f"port {one.port.device}", ok, False, says))
    return found or [Check("ports", False, False, NONE)]
