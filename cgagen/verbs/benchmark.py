"""`cgagen benchmark`: how fast this machine is."""

import click

from cgagen.verbs.console import Console, with_console


@click.command("benchmark")
@with_console
def benchmark_verb(console: Console) -> None:
    """Measure speed on this machine: world steps, a full trial, builds, compiles.

    Takes about a minute. The load of the machine is printed first; on a busy machine the ratios
    say more than the rates.
    """
    from cgagen.benchmark import load, rows

    console.note(load())
    measured = []
    for row in rows():
        measured.append(row._asdict())
        console.note(f"{row.name}: {row.value:.3g} {row.unit}")
    width = max(len(row["name"]) for row in measured)
    table = [
        f"{row['name']:{width}}  {row['value']:10.3f} {row['unit']:9} "
        + (f"(target {row['target']})" if row["target"] else "")
        for row in measured
    ]
    text = "\n".join(line.rstrip() for line in table)
    console.result({"machine": load(), "rows": measured}, text)
