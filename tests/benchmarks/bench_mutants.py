"""The share of small random changes to the code (mutants) that make a test fail.

Each mutant is tried in a copy of the project, first with the tests in the folder that mirrors its
own, and then with the other tests of its package. ``MUTANTS`` is the number of mutants,
``MUTANTS_SEED`` selects other ones, and ``MUTANTS_IN`` limits them to files whose path contains one
of its words.
"""

import ast
import os
import random
import shutil
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import SimpleQueue
from typing import NamedTuple

import pytest
from helpers.command_line import ROOT

PACKAGES = ("warehouse_core", "warehouse_physics", "agents")
NUMBER = int(os.environ.get("MUTANTS", 200))
SEED = int(os.environ.get("MUTANTS_SEED", 0))
WORDS = os.environ.get("MUTANTS_IN", "/").split()
SECONDS = 3600
"""Seconds after which tests that hang count as failed."""

LEAST_SHARE = 0.85

OTHER = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq, ast.In: ast.NotIn, ast.NotIn: ast.In, ast.Is: ast.IsNot, ast.IsNot: ast.Is,
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Add, ast.Div: ast.Mult, ast.FloorDiv: ast.Mod,
    ast.Mod: ast.FloorDiv, ast.BitAnd: ast.BitOr, ast.And: ast.Or, ast.Or: ast.And,
}  # fmt: skip
UNSEEN = ("strict", "slots")
"""Keywords without visible effect; ``strict`` checks what is true, and ``slots`` saves memory."""


class Mutant(NamedTuple):
    """A change of one node in a file.

    Attributes:
        path: path of the file.
        node: number of the node in the order of ``ast.walk``.
        text: description of the change.
    """

    path: str
    node: int
    text: str


class Swap(ast.NodeTransformer):
    """A transformer that replaces one node by another."""

    def __init__(self, old: ast.AST, new: ast.AST) -> None:
        self.old, self.new = old, new

    def visit(self, node: ast.AST) -> ast.AST:
        return self.new if node is self.old else self.generic_visit(node)


def changed(node: ast.AST) -> ast.AST | None:
    """Return a node that may replace another one, or ``None``."""
    match node:
        case ast.Compare(left, [operator], others) if type(operator) in OTHER:
            return ast.Compare(left, [OTHER[type(operator)]()], others)
        case ast.BinOp(left, operator, right) if type(operator) in OTHER:
            return ast.BinOp(left, OTHER[type(operator)](), right)
        case ast.BoolOp(operator, values):
            return ast.BoolOp(OTHER[type(operator)](), values)
        case ast.UnaryOp(ast.Not(), operand):
            return operand
        case ast.keyword(name, ast.Constant(bool() as value)) if name not in UNSEEN:
            return ast.keyword(name, ast.Constant(not value))
        case ast.Constant(int() | float() as value) if not isinstance(value, bool):
            return ast.Constant(value + 1)
        case ast.IfExp(test, body, orelse):
            return ast.IfExp(test, orelse, body)
        case ast.Return(ast.expr() as value) if ast.unparse(value) != "None":
            return ast.Return(ast.Constant(None))
        case ast.Expr(ast.Call()) | ast.AugAssign() | ast.Raise() | ast.Continue() | ast.Break():
            return ast.Pass()
    return None


def mutants_of(path: str) -> Iterator[Mutant]:
    """Yield all mutants of a file."""
    for number, node in enumerate(ast.walk(ast.parse((ROOT / path).read_text()))):
        if new := changed(node):
            line = getattr(node, "lineno", 0)
            yield Mutant(path, number, f"{path}:{line}: {ast.unparse(node)} -> {ast.unparse(new)}")


def is_noticed(mutant: Mutant, copy: Path) -> bool:
    """Return whether tests fail in a copy of the project that contains the mutant."""
    source = (ROOT / mutant.path).read_text()
    tree = ast.parse(source)
    node = [*ast.walk(tree)][mutant.node]
    new = changed(node)
    assert new is not None
    (copy / mutant.path).write_text(ast.unparse(Swap(node, new).visit(tree)))
    tests = Path("tests", str(Path(mutant.path).parent).replace("warehouse_", ""))
    while not (ROOT / tests).is_dir():
        tests = tests.parent
    command = [sys.executable, "-B", "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider"]
    command += [str(tests), str(Path(*tests.parts[:2]))]
    environment = os.environ | {"PYTHONPATH": str(copy)}
    try:
        done = subprocess.run(
            command, cwd=copy, env=environment, timeout=SECONDS, capture_output=True
        )
    except subprocess.TimeoutExpired:
        return True
    finally:
        (copy / mutant.path).write_text(source)
    return done.returncode not in (pytest.ExitCode.OK, pytest.ExitCode.NO_TESTS_COLLECTED)


def test_most_mutants_are_noticed(tmp_path, measured) -> None:
    files = sorted(path for package in PACKAGES for path in ROOT.glob(f"{package}/**/*.py"))
    chosen = [path for path in (str(file.relative_to(ROOT)) for file in files)
              if any(word in path for word in WORDS)]  # fmt: skip
    mutants = [mutant for path in chosen for mutant in mutants_of(path)]
    some = random.Random(SEED).sample(mutants, min(NUMBER, len(mutants)))
    copies = SimpleQueue[Path]()
    for number in range(os.cpu_count() or 1):
        skipped = shutil.ignore_patterns(".venv", ".git", "__pycache__")
        copies.put(shutil.copytree(ROOT, tmp_path / str(number), ignore=skipped))

    def is_missed(mutant: Mutant) -> bool:
        copy = copies.get()
        try:
            return not is_noticed(mutant, copy)
        finally:
            copies.put(copy)

    with ThreadPoolExecutor(copies.qsize()) as pool:
        missed = [
            mutant.text for mutant, it in zip(some, pool.map(is_missed, some), strict=True) if it
        ]
    share = 1 - len(missed) / len(some)
    measured(
        f"mutants caught, {len(some)} random ones of {len(mutants):,} (seed {SEED})", f"{share:.1%}"
    )
    assert share >= LEAST_SHARE, missed
