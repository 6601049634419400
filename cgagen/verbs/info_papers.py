"""What `cgagen info` says of reports, and of what lies in a build or beside a trace."""

import re
from pathlib import Path

from cgagen.notations import parse_toml
from cgagen.shell import command
from cgagen.verbs.info_told import Told, object_in, text_of


def report(path: Path) -> Told:
    """Describe a report as JSON."""
    data = object_in(path)
    robots = {str(one["name"]): str(one["verdict"]) for one in data["robots"]}
    named = ", ".join(f"{name} {verdict}" for name, verdict in robots.items())
    lines = [
        f"{path.name}: a report, {data['verdict']} at level {data['level']}, seed {data['seed']}",
        f"robots: {named or 'none'}",
        f"again: {data['again']}",
    ]
    return Told(lines, {"verdict": data["verdict"], "level": data["level"], "robots": robots})


def page(path: Path) -> Told:
    """Describe a report as a page."""
    found = re.search(r"<title>([A-Z ]+) \S firmware on trial</title>", text_of(path))
    verdict = found[1] if found else "no verdict"
    lines = [f"{path.name}: a report's page, {verdict}; open it in a browser"]
    return Told(lines, {"verdict": verdict})


def kills(path: Path) -> Told:
    """Describe a kill matrix."""
    data = object_in(path)
    mutants, killed, survive = (
        sum(int(row[key]) for row in data["rows"]) for key in ("mutants", "killed", "survivors")
    )
    lines = [
        f"{path.name}: {data['robot']}, image {str(data['image'])[:8]}: {killed} of {mutants} "
        f"mutants killed, {survive} survive"
    ]
    told = {"robot": data["robot"], "mutants": mutants, "killed": killed, "survivors": survive}
    return Told(lines, told)


def sidecar(path: Path) -> Told:
    """Describe what lies beside a trace."""
    data = object_in(path)
    robot, trace = data["robot"], path.name.removesuffix(".json")
    lines = [
        f"{path.name}: says of {trace} that it holds {data['readings']} readings of "
        f"{robot['name']}, decided by {data['target']}"
    ]
    return Told(lines, {"trace": trace, "robot": robot["name"], "readings": data["readings"]})


def frames(path: Path) -> Told:
    """Describe a DBC file."""
    from hil.dbc import dbc_text

    same = text_of(path) == dbc_text()
    which = "as this version has it" if same else "not the one of this version"
    lines = [f"{path.name}: the frames of a stimulus rig for CAN tools, {which}"]
    return Told(lines, {"of_this_version": same})


def memory(path: Path) -> Told:
    """Describe memory.txt."""
    titles = re.findall(r"^(\S.*) \((BS2\w*)\): \d+ bytes of EEPROM$", text_of(path), re.MULTILINE)
    names = [f"{name} ({model})" for name, model in titles]
    lines = [f"{path.name}: what {' and '.join(names)} take of their chips"]
    return Told(lines, {"programs": dict(titles)})


def wiring(path: Path) -> Told:
    """Describe wiring.txt."""
    title, *rest = text_of(path).splitlines()
    pins = sum(bool(re.match(r"\s+P\d+\s", line)) for line in rest)
    return Told([f"{path.name}: {title[0].lower()}{title[1:]}: {pins} pins"], {"pins": pins})


def template(path: Path) -> Told:
    """Describe a template."""
    lines = [f"{path.name}: a template of PBASIC, for the folder of `cgagen build --templates`"]
    return Told(lines, {})


def bench(path: Path) -> Told:
    """Describe a bench file."""
    data = parse_toml(text_of(path))
    count = {key: len(data.get(key, {})) for key in ("chip", "part", "wire", "fault")}
    chips = {
        name: str(row.get("source") or row.get("image"))
        for name, row in data.get("chip", {}).items()
    }
    named = ", ".join(f"{name} {program}" for name, program in chips.items())
    lines = [
        f"{path.name}: a bench: chips {named or 'none'}; {count['part']} parts, {count['wire']} "
        f"wires, {count['fault']} faults",
        f"run it: {command('emulate', path)}",
    ]
    return Told(
        lines, {"chips": chips, **{f"{key}s": count[key] for key in ("part", "wire", "fault")}}
    )


def reports(folder: Path) -> Told:
    """Describe a folder with reports."""
    file = folder / "hil-report.json"
    if not file.is_file():
        told = page(folder / "hil-report.html")
        return Told([f"{folder.name}: a folder with {told.lines[0]}"], told.data)
    return report(file)


def build_record(path: Path) -> Told:
    """Describe a build.json that lies in no build."""
    data = object_in(path)
    robot, genome = data["robot"], data["genome"]
    of = f", genome {str(genome['digest'])[:8]}" if genome else ""
    lines = [f"{path.name}: says what a build of {robot['name']} holds{of}, by digests"]
    return Told(lines, {"robot": robot["name"], "programs": data["programs"]})


def run_record(path: Path) -> Told:
    """Describe a 0-run.toml that lies in no run."""
    data = parse_toml(text_of(path))
    numbers = {
        "seed": data["seed"],
        "trials": data["trials"],
        "generations": data["evolution"]["generations"],
        "population": data["evolution"]["population"],
    }
    lines = [
        "{}: the settings of a run, seed {seed}, {trials} trial(s) of {generations} generations, "
        "population {population}".format(path.name, **numbers)
    ]
    return Told(lines, {"robot": data["genome"]["robot"], **numbers})
