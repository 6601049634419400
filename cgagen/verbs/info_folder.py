"""What `cgagen info` says of a run folder and of a build folder."""

from pathlib import Path

from cgagen.verbs.console import Console


def describe_run(console: Console, folder: Path) -> None:
    """Say what a run folder holds, and whether its best genome is the one that it has evolved."""
    from cgagen.genome import Standing, load, origin_text
    from cgagen.run import read_record

    settings = read_record(folder).settings
    lines = [
        f"{folder.name}: a run, seed {settings.seed}, {settings.trials} trial(s) of "
        f"{settings.generations} generations, population {settings.evolution.population}"
    ]
    best = folder / "best.genome"
    found = load(best) if best.is_file() else None
    said = f" ({origin_text(found)})" if found and found.standing is Standing.EDITED else ""
    lines.append(f"best genome: {best}{said}" if found else "no best genome yet")
    data = {
        "kind": "run",
        "seed": settings.seed,
        "trials": settings.trials,
        "generations": settings.generations,
        "population": settings.evolution.population,
        "has_best": found is not None,
        "best_origin": str(found.standing) if found else None,
    }
    _note_robot(console, best)
    console.result(data, "\n".join(lines))


def _note_robot(console: Console, best: Path) -> None:
    """Say what is to be done where a folder's robot, or a prey, is one of an older release's."""
    from cgagen.errors import CgagenError, RobotError
    from cgagen.whose import home_of

    try:
        home_of(best)
    except RobotError as error:
        console.note(
            f"note: {error}; change a copy of that file, and name the copy with --robot (the "
            "prey of a run, with --opponent)"
        )
    except CgagenError:
        pass  # what the folder lacks is said by whoever needs it


def describe_build(console: Console, folder: Path) -> None:
    """Say what a build takes of its chips, and which of its files were changed since."""
    from cgagen.build import read_record
    from cgagen.build.checked import changed_files
    from cgagen.inputs import BUILD_FILE, read_text

    data, memory = read_record(folder), read_text(folder / "memory.txt", BUILD_FILE)
    changed = changed_files(folder, data)
    _note_robot(console, folder / "best.genome")
    told = f"\nedited since it was built: {', '.join(changed)}" if changed else ""
    console.result(
        {"kind": "build", **data, "changed": changed},
        f"{folder.name}: a build{told}\n\n{memory.rstrip()}",
    )
