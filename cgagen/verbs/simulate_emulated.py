"""`cgagen simulate --emulated`: four Stamps beside the simulator, in step or in their own time."""

from typing import TYPE_CHECKING, Any

from cgagen.verbs.console import Console

if TYPE_CHECKING:
    from hil.hunt import Hunt
    from hil.parting import Parting
    from hil.subject import Subject


def emulated(
    console: Console, given: dict[str, Any], parts: Any, numbers: Any, start: Any
) -> tuple[dict[str, Any], str, str | None]:
    """Build what has to be built, and hunt with it.

    Returns:
        The verdict as data, as a line, and as the sentence of a mismatch, None for none.
    """
    from hil.hunt import hunt
    from hil.parting import part
    from hil.subject import unlike

    genome, predator, prey = parts
    hunter, hunted = _subjects(given["build"], genome, predator, prey)
    # A hunt need not meet the gene that differs.
    other = unlike(hunter, predator, genome) if given["build"] else ""
    console.note("emulating four Stamps: about a fifth of a second for a step")
    free = [one.robot.name for one in (hunter, hunted) if one.robot.link.step_line is None]
    if given["no_referee"] or free:
        if free:
            console.note(f"{' and '.join(free)}: no step line, so each robot walks in its own time")
        parting = part(hunter, hunted, numbers, start, given["steps"], genome)
        return _parted(parting), _parted_text(parting), parting.trouble or other or None
    hunting = hunt(hunter, hunted, numbers, start, given["steps"], genome)
    difference = hunting.difference.text() if hunting.difference else other
    return _verdict(hunting), _verdict_text(hunting), difference or None


def _subjects(build: Any, genome: Any, predator: Any, prey: Any) -> "tuple[Subject, Subject]":
    from cgagen.build import make_build
    from cgagen.tokenizer import Tokenizer
    from hil.subject import read_subject, subject_of

    with Tokenizer() as tokenizer:
        hunter = (
            read_subject(build)
            if build
            else subject_of(make_build(predator, genome, tokenizer), predator.name)
        )
        return hunter, subject_of(make_build(prey, None, tokenizer), prey.name)


def _verdict(hunt: "Hunt") -> dict[str, Any]:
    return {
        "steps": len(hunt.steps),
        "captured_at_step": hunt.captured_at,
        "robot_time_ms": hunt.steps[-1].time_ns // 1_000_000 if hunt.steps else None,
        "difference": hunt.difference and hunt.difference.text(),
    }


def _verdict_text(hunt: "Hunt") -> str:
    if hunt.difference is not None:
        return f"differ at step {hunt.difference.step}"
    seconds = hunt.steps[-1].time_ns / 1e9
    return f"{len(hunt.steps)} steps, all equal, in {seconds:.1f} s of the robots' time"


def _parted(parting: "Parting") -> dict[str, Any]:
    return {
        "referee": False,
        "steps": parting.predator_steps,
        "prey_steps": parting.prey_steps,
        "captured_at_step": parting.captured_at,
        "decided_alike": parting.decided_alike,
        "farthest_units": parting.farthest_units,
        "difference": parting.trouble or None,
    }


def _parted_text(parting: "Parting") -> str:
    if parting.trouble:
        return f"in trouble after {parting.predator_steps} movements"
    end = (
        f"captured at movement {parting.captured_at}"
        if parting.captured_at
        else f"not captured in {parting.predator_steps} movements"
    )
    return (
        f"each in its own time, {end}; the first {parting.decided_alike} decisions are the "
        f"simulator's, and the predators were at most {parting.farthest_units:.1f} units apart "
        "after as many movements"
    )
