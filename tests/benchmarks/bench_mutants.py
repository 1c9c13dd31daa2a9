"""The share of small changes to the code, drawn at random, that make a test fail.

Each is tried in a copy of the project with the tests that reach its line, which coverage.py has
recorded for a run of the default tests. ``MUTANTS`` is their number, ``MUTANTS_SEED`` draws others,
and ``MUTANTS_IN`` limits them to files whose path contains one of its words. ``MUTANTS_COVERAGE``
is the file of what is recorded; if it exists, it is read in place of a new run.
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

import coverage
import pytest
from helpers.command_line import ROOT

PACKAGES = ("warehouse_core", "warehouse_physics", "agents")
NUMBER = int(os.environ.get("MUTANTS", 200))
SEED = int(os.environ.get("MUTANTS_SEED", 0))
WORDS = os.environ.get("MUTANTS_IN", "/").split()
SECONDS = 300
"""After which a mutant that hangs counts as noticed."""

LEAST_SHARE = 0.95

OTHER = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq, ast.In: ast.NotIn, ast.NotIn: ast.In, ast.Is: ast.IsNot, ast.IsNot: ast.Is,
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Add, ast.Div: ast.Mult, ast.FloorDiv: ast.Mod,
    ast.Mod: ast.FloorDiv, ast.BitAnd: ast.BitOr, ast.BitOr: ast.BitAnd, ast.And: ast.Or,
    ast.Or: ast.And,
}  # fmt: skip
OTHER_NAMES = {"min": "max", "max": "min", "any": "all", "all": "any"}


class Mutant(NamedTuple):
    """A part of a line, in bytes, and what takes its place."""

    path: str
    line: int
    start: int
    end: int
    old: str
    new: str

    def source(self) -> bytes:
        lines = (ROOT / self.path).read_bytes().splitlines(keepends=True)
        line = lines[self.line - 1]
        lines[self.line - 1] = line[: self.start] + self.new.encode() + line[self.end :]
        return b"".join(lines)

    def __str__(self) -> str:
        return f"{self.path}:{self.line}: {self.old}  ->  {self.new}"


def changed(node: ast.AST) -> Iterator[ast.AST]:
    """Yield what may take the place of a node."""
    match node:
        case ast.Compare(left, [operator], others) if type(operator) in OTHER:
            yield ast.Compare(left, [OTHER[type(operator)]()], others)
        case ast.BinOp(left, operator, right) if type(operator) in OTHER:
            yield ast.BinOp(left, OTHER[type(operator)](), right)
        case ast.BoolOp(operator, values):
            yield ast.BoolOp(OTHER[type(operator)](), values)
        case ast.UnaryOp(ast.Not() | ast.USub(), operand):
            yield operand
        case ast.Constant(bool() as value):
            yield ast.Constant(not value)
        case ast.Constant(int() | float() as value):
            yield ast.Constant(value + 1)
        case ast.Call(ast.Name(name), arguments, keywords) if name in OTHER_NAMES:
            yield ast.Call(ast.Name(OTHER_NAMES[name]), arguments, keywords)
        case ast.IfExp(test, body, orelse):
            yield ast.IfExp(test, orelse, body)
        case ast.Return(value) if value is not None:
            yield ast.Return(None)
        case ast.Expr(ast.Call()) | ast.AugAssign() | ast.Raise() | ast.Continue() | ast.Break():
            yield ast.Pass()


def mutants_of(path: str) -> Iterator[Mutant]:
    """Yield all mutants of a file, one line each; annotations and texts are left alone."""
    source = (ROOT / path).read_text()
    tree = ast.parse(source)
    notes = {
        id(inner)
        for node in ast.walk(tree)
        for note in (getattr(node, "annotation", None), getattr(node, "returns", None))
        if note is not None
        for inner in ast.walk(note)
    }
    for node in ast.walk(tree):
        if id(node) in notes or getattr(node, "lineno", 0) != getattr(node, "end_lineno", None):
            continue
        for new in changed(node):
            text = ast.unparse(ast.fix_missing_locations(new))
            if isinstance(new, ast.expr) and not isinstance(new, ast.Constant | ast.Name):
                text = f"({text})"
            old = ast.get_source_segment(source, node)
            yield Mutant(path, node.lineno, node.col_offset, node.end_col_offset, old, text)


def run_default_tests(data: Path) -> None:
    """Record in a file which of them reach which line."""
    packages = [f"--cov={package}" for package in PACKAGES]
    options = ["-q", "-n", "auto", "--cov-context=test", "--cov-report=", *packages]
    command = [sys.executable, "-m", "pytest", *options]
    environment = os.environ | {"COVERAGE_FILE": str(data)}
    subprocess.run(command, cwd=ROOT, env=environment, check=True)


def reaching(mutant: Mutant, data: coverage.CoverageData) -> list[str]:
    """Return the tests that reach a mutant's line, those of its own module first.

    A line that only an import or another process reaches has all tests of its folder.
    """
    contexts = data.contexts_by_lineno(str(ROOT / mutant.path)).get(mutant.line, [])
    names = {context.partition("|")[0].partition("[")[0] for context in contexts} - {""}
    own = f"test_{Path(mutant.path).stem}.py"
    found = sorted(names, key=lambda name: (own not in name, name))
    folder = Path("tests", str(Path(mutant.path).parent).replace("warehouse_", ""))
    while not (ROOT / folder).is_dir():
        folder = folder.parent
    return found or [str(folder), "tests/system"]


def is_noticed(mutant: Mutant, tests: list[str], copy: Path) -> bool:
    """Run tests in a copy of the project with the mutant, and return whether one fails."""
    target = copy / mutant.path
    target.write_bytes(mutant.source())
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", *tests]
    # A cached file would be taken for that of a mutant of the same second and size.
    environment = os.environ | {"PYTHONDONTWRITEBYTECODE": "1"}
    try:
        # With -m, the copy's packages come before those that are installed.
        ended = subprocess.run(
            command, cwd=copy, env=environment, capture_output=True, timeout=SECONDS
        )
    except subprocess.TimeoutExpired:
        return True
    finally:
        shutil.copyfile(ROOT / mutant.path, target)
    assert ended.returncode != pytest.ExitCode.NO_TESTS_COLLECTED, tests
    return ended.returncode != 0


def test_nearly_all_mutants_are_noticed(tmp_path, measured) -> None:
    files = sorted(path for package in PACKAGES for path in ROOT.glob(f"{package}/**/*.py"))
    paths = [str(path.relative_to(ROOT)) for path in files]
    chosen = [path for path in paths if any(word in path for word in WORDS)]
    all_mutants = [mutant for path in chosen for mutant in mutants_of(path)]
    some = random.Random(SEED).sample(all_mutants, min(NUMBER, len(all_mutants)))
    recorded = Path(os.environ.get("MUTANTS_COVERAGE", tmp_path / "coverage"))
    if not recorded.exists():
        run_default_tests(recorded)
    data = coverage.CoverageData(str(recorded))
    data.read()
    copies = SimpleQueue[Path]()
    for number in range(os.cpu_count() or 1):
        hidden = shutil.ignore_patterns(".*", "__pycache__")
        copies.put(shutil.copytree(ROOT, tmp_path / str(number), ignore=hidden))
        shutil.copytree(ROOT / ".github", tmp_path / str(number) / ".github")

    def try_one(mutant: Mutant) -> bool:
        copy = copies.get()
        try:
            is_good = is_noticed(mutant, reaching(mutant, data), copy)
        finally:
            copies.put(copy)
        if not is_good:
            print(mutant, flush=True)
        return is_good

    with ThreadPoolExecutor(copies.qsize()) as pool:
        noticed = list(pool.map(try_one, some))
    share = sum(noticed) / len(some)
    measured(f"mutants noticed, of {len(some)} drawn from {len(all_mutants)}", f"{share:.1%}")
    missed = [str(mutant) for mutant, is_good in zip(some, noticed, strict=True) if not is_good]
    assert share >= LEAST_SHARE, missed
