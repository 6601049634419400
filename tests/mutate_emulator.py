"""Mutate the emulator's arithmetic and control flow, and see whether the tests notice.

    python -m tests.mutate_emulator [--count 120] [--seed 1]

One small change at a time is made in a copy of the project (a comparison, an operator, a constant,
a condition), and the tests of the emulator's core run on it. What survives is printed: each is a
missing test, or a change that changes nothing; those of the second kind are in `EQUIVALENT`, with
the reason, and are not counted. A run that takes too long is counted apart from one that fails.
"""

import argparse
import ast
import os
import random
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from enum import StrEnum
from pathlib import Path

ROOT = Path(__file__).parent.parent
MODULES = ("arithmetic", "registers", "expressions", "instructions", "machine", "block_text")
TESTED_BY = (
    "arithmetic registers expressions block_text chip chip_slots chip_pins polling programs blocks"
)
TESTS = tuple(f"test_{name}.py" for name in TESTED_BY.split())
LIMIT_S = 300
"""How long the tests may take; they take a tenth of it. Ref: choice."""

EQUIVALENT: dict[tuple[str, str, str], str] = {
    (
        "arithmetic",
        "bits = y & 15 if wide is Wide.WRAPS and y > 16 else min(y, 32)",
        "32 -> 33",
    ): "a word of 16 bits is gone after 32 shifts: one more changes nothing",
    (
        "arithmetic",
        "table = [_whole(127 * function(x * pi / 128), rounding) & WORD for x in range(256)]",
        "256 -> 257",
    ): "the table is read by a byte",
    (
        "expressions",
        "return stack.pop() if stack else 0",
        "0 -> 1",
    ): "a store leaves an empty stack, and nobody asks what it returns",
    (
        "expressions",
        "return 7 + (width if token.value & token.value - 1 else 0)",
        "1 -> 2",
    ): "no number but 0 and the powers of 2 loses all its bits that way either; of 1 there are 0",
}
"""Reviewed changes that change nothing: module, line of text, what was done; and why."""

COMPARISONS: dict[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt,
    ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
}  # fmt: skip
OPERATORS: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.FloorDiv, ast.FloorDiv: ast.Mult,
    ast.LShift: ast.RShift, ast.RShift: ast.LShift, ast.BitAnd: ast.BitOr, ast.BitOr: ast.BitAnd,
    ast.BitXor: ast.BitOr, ast.Mod: ast.FloorDiv,
}  # fmt: skip


def places(tree: ast.Module) -> Iterator[ast.AST]:
    """Return the nodes that can be mutated, in the order of the text."""
    for node in ast.walk(tree):
        match node:
            case ast.Compare(ops=[operator]) if type(operator) in COMPARISONS:
                yield node
            case ast.BinOp(op=operator) if type(operator) in OPERATORS:
                yield node
            case ast.Constant(value=int() as value) if not isinstance(value, bool):
                yield node
            case ast.BoolOp() | ast.IfExp() | ast.If():
                yield node


def mutate(node: ast.AST) -> str:
    """Change one node; return what was done."""
    match node:
        case ast.Compare(ops=[operator]):
            node.ops = [COMPARISONS[type(operator)]()]
            return f"{type(operator).__name__} -> {type(node.ops[0]).__name__}"
        case ast.BinOp(op=operator):
            node.op = OPERATORS[type(operator)]()
            return f"{type(operator).__name__} -> {type(node.op).__name__}"
        case ast.Constant(value=int() as value):
            node.value = value + 1
            return f"{value} -> {value + 1}"
        case ast.BoolOp(op=ast.And()):
            node.op = ast.Or()
            return "and -> or"
        case ast.BoolOp():
            node.op = ast.And()
            return "or -> and"
        case ast.IfExp() | ast.If():
            node.test = ast.UnaryOp(ast.Not(), node.test)
            return "condition negated"
    raise TypeError(f"{node} cannot be mutated")


class Fate(StrEnum):
    """What became of a change."""

    KILLED = "killed"
    TIMED_OUT = "timed out"
    SURVIVED = "survived"
    EQUIVALENT = "equivalent"


def fate_of(copy: Path) -> Fate:
    """Run the tests on the copy, and the examples in the modules themselves."""
    examples = [copy / "cgagen" / "emulator" / f"{name}.py" for name in MODULES]
    words = [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", "--no-header"]
    environment = os.environ | {"PYTHONPATH": str(copy), "HYPOTHESIS_PROFILE": "default"}
    try:
        done = subprocess.run(
            [*words, *(str(copy / "tests" / name) for name in TESTS), *map(str, examples)],
            cwd=copy, env=environment, capture_output=True, timeout=LIMIT_S, check=False,
            stdin=subprocess.DEVNULL,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return Fate.TIMED_OUT
    return Fate.KILLED if done.returncode else Fate.SURVIVED


def main() -> int:
    """Run a seeded sample and print the kill rate."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=120)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder)
        for name in ("cgagen", "sim", "hil", "tests", "templates", "firmware"):
            shutil.copytree(ROOT / name, copy / name, ignore=shutil.ignore_patterns("__pycache__"))
        shutil.copy(ROOT / "pyproject.toml", copy)
        if fate_of(copy) is not Fate.SURVIVED:
            print("the tests fail before anything is changed")
            return 1
        candidates = [
            (module, index)
            for module in MODULES
            for index, _ in enumerate(places(ast.parse(source_of(ROOT, module))))
        ]
        sample = random.Random(given.seed).sample(candidates, min(given.count, len(candidates)))
        fates = Counter(try_one(copy, *place) for place in sorted(sample))
    counted = len(sample) - fates[Fate.EQUIVALENT]
    noticed = fates[Fate.KILLED] + fates[Fate.TIMED_OUT]
    print(
        f"seed {given.seed}: {noticed} of {counted} mutants noticed ({noticed / counted:.1%}): "
        f"{fates[Fate.KILLED]} killed, {fates[Fate.TIMED_OUT]} timed out; "
        f"{fates[Fate.EQUIVALENT]} equivalent ones besides"
    )
    return 0


def source_of(root: Path, module: str) -> str:
    """Return the text of one module of the emulator."""
    return (root / "cgagen" / "emulator" / f"{module}.py").read_text("utf-8")


def try_one(copy: Path, module: str, index: int) -> Fate:
    """Mutate one place in the copy and run the tests; print what nobody noticed."""
    original = source_of(ROOT, module)
    tree = ast.parse(original)
    node = list(places(tree))[index]
    number = getattr(node, "lineno", 0)
    text = original.splitlines()[number - 1].strip()
    what = mutate(node)
    if (module, text, what) in EQUIVALENT:
        return Fate.EQUIVALENT
    path = copy / "cgagen" / "emulator" / f"{module}.py"
    path.write_text(ast.unparse(tree), "utf-8")
    fate = fate_of(copy)
    path.write_text(original, "utf-8")
    if fate is not Fate.KILLED:
        print(f"{fate}: {module}.py:{number}: {what}: {text}", flush=True)
    return fate


if __name__ == "__main__":
    raise SystemExit(main())
