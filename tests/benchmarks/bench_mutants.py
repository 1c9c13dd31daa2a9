"""The share of small changes to the code, drawn at random, that make a test fail.

Each is tried in a copy of the project with the tests that reach its line, which coverage.py has
recorded for a run of the default tests. ``MUTANTS`` is their number, ``MUTANTS_SEED`` draws others,
and ``MUTANTS_IN`` limits them to files whose path contains one of its words. ``MUTANTS_COVERAGE``
is the file of what is recorded; if it exists, it is read in place of a new run.

Why not mutmut: in its version 3.8, too, it leaves constants, properties and cached functions alone,
about an eighth of all mutants here and most in ``task/rules.py``. Cosmic-ray runs all tests for
each mutant.
"""

import ast
import os
import random
import shutil
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import cache
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
SECONDS = 200
"""Time after which a test that hangs counts as failed."""

OPTIONS = [
    "-x", "-q", "-rfE", "-p", "no:cacheprovider",
    "-o", f"faulthandler_timeout={SECONDS}", "-o", "faulthandler_exit_on_timeout=true",
]  # fmt: skip

LEAST_SHARE = 0.95

OTHER = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq, ast.In: ast.NotIn, ast.NotIn: ast.In, ast.Is: ast.IsNot, ast.IsNot: ast.Is,
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Add, ast.Div: ast.Mult, ast.FloorDiv: ast.Mod,
    ast.Mod: ast.FloorDiv, ast.BitAnd: ast.BitOr, ast.BitOr: ast.BitAnd, ast.And: ast.Or,
    ast.Or: ast.And,
}  # fmt: skip
UNSEEN = ("strict", "slots")
"""Keywords that change nothing if they are false: a check of what holds already, and memory."""

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
        case ast.Return(ast.Constant(None)):  # a mutant would do the same
            return
        case ast.Return(value) if value is not None:
            yield ast.Return(None)
        case ast.Expr(ast.Call()) | ast.AugAssign() | ast.Raise() | ast.Continue() | ast.Break():
            yield ast.Pass()


def parts_without_effect(node: ast.AST) -> Iterator[ast.AST | None]:
    """Yield annotations, and parts of a node whose mutants do the same as they do."""
    yield from (getattr(node, "annotation", None), getattr(node, "returns", None))
    match node:
        case ast.keyword(str() as name, ast.Constant(True) as value) if name in UNSEEN:
            yield value
        case ast.Call(ast.Attribute(_, "reshape"), arguments):  # -2 is the rest of an array too
            yield from (each.operand for each in arguments if isinstance(each, ast.UnaryOp))


def mutants_of(path: str) -> Iterator[Mutant]:
    """Yield all mutants of a file, one line each; annotations and texts are left alone."""
    source = (ROOT / path).read_bytes()
    tree, lines = ast.parse(source), source.splitlines()
    notes = {
        id(inner)
        for node in ast.walk(tree)
        for note in parts_without_effect(node)
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
            old = lines[node.lineno - 1][node.col_offset : node.end_col_offset].decode()
            yield Mutant(path, node.lineno, node.col_offset, node.end_col_offset, old, text)


def run_default_tests(data: Path) -> None:
    """Record in a file which of them reach which line."""
    packages = [f"--cov={package}" for package in PACKAGES]
    options = ["-q", "-n", "auto", "--cov-context=test", "--cov-report=", *packages]
    command = [sys.executable, "-m", "pytest", *options]
    environment = os.environ | {"COVERAGE_FILE": str(data)}
    subprocess.run(command, cwd=ROOT, env=environment, check=True)


def reaching(mutant: Mutant, data: coverage.CoverageData) -> list[str]:
    """Return the tests that may notice a mutant: those that reach its line, then its folder's.

    The folder comes too because only the first test reaches a line whose outcome is cached. No test
    reaches a constant, or a line that another process runs: those have all tests of the package.
    """
    contexts = contexts_of(ROOT / mutant.path, data).get(mutant.line, [])
    tests = {context.partition("|")[0].partition("[")[0] for context in contexts} - {""}
    name = f"test_{Path(mutant.path).stem}.py"
    folder = Path("tests", str(Path(mutant.path).parent).replace("warehouse_", ""))
    while not (ROOT / folder).is_dir():
        folder = folder.parent
    near = [*sorted(tests, key=lambda test: (name not in test, test)), str(folder)]
    return near if tests else [*near, str(Path(*folder.parts[:2]))]


class Copy:
    """A copy of the project in which pytest runs."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        shutil.copytree(ROOT, folder, ignore=shutil.ignore_patterns(".*", "__pycache__"))
        shutil.copytree(ROOT / ".github", folder / ".github")
        # Bytecode known by the hash of its source: a mutant may have the time and size of another.
        command = [sys.executable, "-m", "compileall", "-q", "--invalidation-mode", "checked-hash"]
        subprocess.run([*command, *PACKAGES], cwd=folder, check=True)

    def run(self, tests: list[str]) -> tuple[int, list[str]]:
        """Run tests until one fails; return the exit code and which failed."""
        command = [sys.executable, "-m", "pytest", *OPTIONS, *tests]
        environment = os.environ | {"PYTHONDONTWRITEBYTECODE": "1"}
        done = subprocess.run(
            command, cwd=self.folder, env=environment, capture_output=True, text=True
        )
        failed = [
            line.partition(" ")[2]
            for line in done.stdout.splitlines()
            if line.startswith(("FAILED ", "ERROR "))
        ]
        code = done.returncode
        if code == pytest.ExitCode.USAGE_ERROR and "ERROR collecting" in done.stdout:
            code = pytest.ExitCode.INTERRUPTED  # tests that were named are not found then
        return code, [each.partition(" - ")[0].partition("[")[0] for each in failed]

    def run_with(self, mutant: Mutant, tests: list[str]) -> tuple[int, list[str]]:
        target = self.folder / mutant.path
        target.write_bytes(mutant.source())
        try:
            return self.run(tests)
        finally:
            shutil.copyfile(ROOT / mutant.path, target)


@cache
def contexts_of(path: Path, data: coverage.CoverageData) -> dict[int, list[str]]:
    return data.contexts_by_lineno(str(path))


def sources() -> list[Path]:
    return sorted(path for package in PACKAGES for path in ROOT.glob(f"{package}/**/*.py"))


def test_nearly_all_mutants_are_noticed(tmp_path, measured) -> None:
    paths = [str(path.relative_to(ROOT)) for path in sources()]
    chosen = [path for path in paths if any(word in path for word in WORDS)]
    all_mutants = [mutant for path in chosen for mutant in mutants_of(path)]
    some = random.Random(SEED).sample(all_mutants, min(NUMBER, len(all_mutants)))
    recorded = Path(os.environ.get("MUTANTS_COVERAGE", tmp_path / "coverage"))
    if not recorded.exists():
        run_default_tests(recorded)
    data = coverage.CoverageData(str(recorded))
    data.read()
    copies = SimpleQueue[Copy]()
    for number in range(os.cpu_count() or 1):
        one = Copy(tmp_path / str(number))
        copies.put(one)

    def try_one(mutant: Mutant) -> tuple[bool, list[str]]:
        copy = copies.get()
        try:
            code, failed = copy.run_with(mutant, reaching(mutant, data))
        finally:
            copies.put(copy)
        # A signal or an error while tests are collected notices it too, a wrong call does not.
        assert code <= pytest.ExitCode.INTERRUPTED, (mutant, pytest.ExitCode(code))
        # The other standard output is captured by ``capsys``, which ``measured`` uses.
        print("noticed" if code else "missed", mutant, *failed, file=sys.__stdout__, flush=True)
        return code != 0, failed

    with ThreadPoolExecutor(copies.qsize()) as pool:
        tried = list(pool.map(try_one, some))
        # A test that fails without a mutant too notices nothing.
        failing = sorted({test for _, failed in tried for test in failed})
        assert not failing or one.run(["-m", "", *failing]) == (0, [])
    noticed = [is_good for is_good, _ in tried]
    share = sum(noticed) / len(some)
    measured(f"mutants noticed, of {len(some)} drawn from {len(all_mutants)}", f"{share:.1%}")
    missed = [str(mutant) for mutant, is_good in zip(some, noticed, strict=True) if not is_good]
    assert share >= LEAST_SHARE, missed
