"""`cgagen flash`: images into Stamps."""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cgagen.verbs.console import Console, with_console

if TYPE_CHECKING:
    from cgagen.flash import FlashReport, Module, Progress
    from cgagen.stamp.chips import Chip
    from cgagen.stamp.image import Image

EMULATED = "emu"

PORT_HELP = (
    "auto (the only one that answers), a device, id:SERIAL, rfc2217://HOST:PORT, or emu (blank "
    "emulated Stamps, gone afterwards)."
)


@click.command("flash")
@click.argument(
    "target", metavar="[BUILD|IMAGE|SOURCE]", type=click.Path(path_type=Path), required=False
)
@click.option("--port", default="auto", show_default=True, metavar="PORT", help=PORT_HELP)
@click.option("--main", metavar="PORT", help="Of a BUILD: the main controller's port.")
@click.option("--locomotion", metavar="PORT", help="Of a BUILD: the locomotion controller's.")
@click.option("--model", metavar="NAME", help="The chip of a bare IMAGE: BS2, BS2e, BS2sx, ...")
@click.option("--slot", type=click.IntRange(0, 7), default=0, help="Of a bare IMAGE or a SOURCE.")
@click.option("--identify-only", is_flag=True, help="Say what is on the port, and send nothing.")
@click.option("--dry-run", is_flag=True, help="Say what would be sent; opens no port.")
@click.option("--verify", is_flag=True, help="Read back what was sent, through the bench hook.")
@with_console
def flash_verb(console: Console, /, target: Path | None, **given: Any) -> None:
    r"""Program BASIC Stamps over their programming ports.

    A BUILD folder goes into both Stamps of its robot; each port is asked which module it has. An
    IMAGE of a build goes into one Stamp, and so does a PBASIC SOURCE, which is compiled, with the
    files that its $STAMP line names for further slots; a bare IMAGE of 2,048 bytes is sent whole,
    and needs --model where no source that makes it lies beside it. The Stamp is identified first,
    every packet must be acknowledged, and the program is started at the end. What goes wrong on
    the line is tried again, three times at most.

    --verify asks the firmware itself, after a reset, for every block that was sent: what the
    running program reads from its own EEPROM is then what was sent. It says nothing of blocks
    that were not sent, and works with this project's firmware only, which lies in slot 0.

    \b
    Exit codes:
      0  every packet was acknowledged
      3  the image, or the build that it lies in, is not fit to be sent
      6  the tokenizer refuses the source
      7  a port or what hangs on it is sick, or it is another model; nothing was sent
      8  a download had begun and failed: flash again before the robot runs
    """
    if given["identify_only"]:
        _identify(console, given["port"])
    elif target is None:
        raise click.UsageError("name a build folder, an image or a source; or give --identify-only")
    elif target.is_dir():
        _flash_folder(console, target, given)
    else:
        _flash_file(console, target, given)


def _identify(console: Console, place: str) -> None:
    from cgagen.flash import identify_port
    from cgagen.link.ports import choose_port

    port = choose_port(place, lambda name: _module_at(console, name) is not None)
    module = identify_port(port)
    console.result({"port": port, **module_data(module)}, f"{port}: {module_text(module)}")


def _flash_folder(console: Console, folder: Path, given: dict[str, Any]) -> None:
    from cgagen.build.checked import checked_images
    from cgagen.build.flashing import flash_build

    if given["model"] or given["port"] not in ("auto", EMULATED) or given["slot"]:
        raise click.UsageError(
            "a build knows its models; give --main and --locomotion, or name one of its images"
        )
    if given["dry_run"]:
        _dry_run(console, checked_images(folder))
        return
    named = {chip: given[chip] for chip in ("main", "locomotion") if given[chip]}
    with ExitStack() as stack:
        if given["port"] == EMULATED:
            named = stack.enter_context(_emulated_robot(folder))
        tell = stack.enter_context(watched(console))
        reports = flash_build(folder, named, verify=given["verify"], progress=tell)
    _report(console, reports)


def _emulated_robot(folder: Path) -> AbstractContextManager[dict[str, str]]:
    from cgagen.build.checked import checked_images
    from cgagen.build.record import ROBOT_FILE
    from cgagen.verbs.emulated_port import emulated_robot

    models = {chip: image.model for chip, image in checked_images(folder).items()}
    return emulated_robot(folder / ROBOT_FILE, models)


def _flash_file(console: Console, file: Path, given: dict[str, Any]) -> None:
    from cgagen.build.flashing import flash_in_turn
    from cgagen.link.ports import choose_port
    from cgagen.verbs.flash_file import images_at

    if given["main"] or given["locomotion"]:
        raise click.UsageError("--main and --locomotion are for a build; give --port")
    images = images_at(console, file, given["model"], given["slot"])
    if given["dry_run"]:
        _dry_run(console, images)
        return
    model = images[file.stem].model

    def answers(name: str) -> bool:
        module = _module_at(console, name, model)
        return module is not None and module.model == model

    with ExitStack() as stack:
        if given["port"] == EMULATED:
            from cgagen.verbs.emulated_port import emulated_chip

            port = stack.enter_context(emulated_chip(model))
        else:
            port = choose_port(given["port"], answers)
        tell = stack.enter_context(watched(console))
        jobs = {name: (port, image) for name, image in images.items()}
        reports = flash_in_turn(jobs, verify=given["verify"], progress=tell)
    _report(console, reports)


def _module_at(console: Console, port: str, *likely: "Chip") -> "Module | None":
    """Return the module on a port, and note what it is; None where none answers."""
    from cgagen.errors import CgagenError
    from cgagen.flash import identify_port

    try:
        module = identify_port(port, likely) if likely else identify_port(port)
    except CgagenError as error:
        console.note(f"note: {error}")
        return None
    console.note(f"note: {port}: {module_text(module)}")
    return module


def _dry_run(console: Console, images: "dict[str, Image]") -> None:
    from cgagen.flash import plan_of

    plans = {name: plan_of(image) for name, image in images.items()}
    data = {
        name: {
            "model": plan.image.model.name,
            "slot": plan.image.slot,
            "blocks": list(plan.blocks),
            "packets": [packet.hex() for packet in plan.packets],
        }
        for name, plan in plans.items()
    }
    text = "\n\n".join(f"{name}, {plan.to_text()}" for name, plan in plans.items())
    console.result(data, f"{text}\n\nnothing was sent")


def _report(console: Console, reports: "dict[str, FlashReport]") -> None:
    data = {
        name: {
            "port": report.port,
            **module_data(report.module),
            "slot": report.slot,
            "blocks": len(report.blocks),
            "attempts": report.attempts,
            "image": report.image_digest,
            "talks": report.talks,
            "verified_blocks": report.verified,
        }
        for name, report in reports.items()
    }
    console.result(data, "\n".join(_line(name, report) for name, report in reports.items()))


def _line(name: str, report: "FlashReport") -> str:
    again = f" at attempt {report.attempts}" if report.attempts > 1 else ""
    slot = f" into slot {report.slot}" if report.slot else ""
    text = (
        f"{name}: {report.module.name} on {report.port} has taken all {len(report.blocks)} "
        f"packets{slot}{again}, image {report.image_digest[:8]}; {_seen(report)}"
    )
    if report.verified is not None:
        text += f"; {report.verified} blocks read back by the program itself are equal"
    return text


def _seen(report: "FlashReport") -> str:
    """Return what was seen of the program that runs: after a reset that is the one in slot 0."""
    if report.slot:
        return "slot 0 runs and talks" if report.talks else "slot 0 was started by a reset"
    return "it talks" if report.talks else "started by a reset, nothing heard of it yet"


def module_data(module: "Module") -> dict[str, Any]:
    """Return a module for `--json`."""
    return {"module": module.name, "model": module.model.name, "version": module.version}


def module_text(module: "Module") -> str:
    """Return a module as a reader sees it."""
    return f"{module.name}, interpreter version {module.version}"


@contextmanager
def watched(console: Console) -> "Iterator[Callable[[str, Progress], None]]":
    """Give an observer of packets: a line on a terminal that counts, or one line per download."""
    open_line = False

    def tell(chip: str, step: "Progress") -> None:
        nonlocal open_line
        text = f"{chip}: packet {step.done} of {step.total}"
        text += f", attempt {step.attempt}" if step.attempt > 1 else ""
        if console.progress:
            click.echo(f"\r{text}", err=True, nl=step.done == step.total)
            open_line = step.done < step.total
        elif console.verbose:
            console.note(text)

    try:
        yield tell
    finally:
        if open_line:
            click.echo("", err=True)
