"""`cgagen ports`: what serial ports there are, and what hangs on them."""

from typing import TYPE_CHECKING, Any

import click

from cgagen.verbs.console import Console, with_console

if TYPE_CHECKING:
    from cgagen.link.condition import Condition


@click.command("ports")
@click.option(
    "--identify", is_flag=True, help="Reset what hangs on them, and ask which Stamp it is."
)
@with_console
def ports_verb(console: Console, /, identify: bool) -> None:
    """List the serial ports of this machine, and say whether they can be used.

    No port is opened, so that nothing is reset. With --identify every port is: a Stamp is reset,
    says its model, and starts its program anew, so a robot may walk.
    """
    from cgagen.link.condition import all_conditions
    from cgagen.link.ports import NONE

    conditions = all_conditions()
    modules = {one.port.device: ask(one) for one in conditions} if identify else {}
    console.result(
        [_data(one, modules) for one in conditions],
        "\n".join(_text(one, modules) for one in conditions) or NONE,
    )


def ask(one: "Condition") -> tuple[dict[str, Any] | None, str]:
    """Return the module of a port, and the words about it; no module where none answers."""
    from cgagen.errors import CgagenError
    from cgagen.flash import identify_port
    from cgagen.verbs.flash import module_data, module_text

    if not one.ok:
        return None, one.says
    try:
        module = identify_port(one.port.device)
    except CgagenError as error:
        return None, str(error).removeprefix(f"{one.port.device}: ")
    return module_data(module), module_text(module)


def _text(one: "Condition", modules: dict[str, tuple[dict[str, Any] | None, str]]) -> str:
    words = modules[one.port.device][1] if modules else one.says
    return f"{one.port.to_text()}: {words}"


def _data(
    one: "Condition", modules: dict[str, tuple[dict[str, Any] | None, str]]
) -> dict[str, Any]:
    data: dict[str, Any] = {
        "device": one.port.device,
        "usb": one.port.usb or None,
        "serial": one.port.serial or None,
        "words": one.port.words,
        "ok": one.ok,
        "says": one.says,
    }
    if modules:
        module, words = modules[one.port.device]
        data |= {"found": module, "ok": module is not None, "says": words}
    return data
