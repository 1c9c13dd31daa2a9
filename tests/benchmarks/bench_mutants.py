"""The share of small changes to the code, drawn at random, that make a test fail.

Each is tried in a copy of the project with the tests that reach its line, which coverage.py has
recorded for a run of the default tests. ``MUTANTS`` is their number, ``MUTANTS_SEED`` draws others,
and ``MUTANTS_IN`` limits them to files whose path contains one of its words. ``MUTANTS_COVERAGE``
is the file of what is recorded; if it exists, it is read in place of a new run.
"""

import ast
import compileall
import json
import os
import py_compile
import random
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
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
"""After which a test that hangs counts as failed."""

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


def mutants_of(path: str) -> Iterator[Mutant]:
    """Yield all mutants of a file, one line each; annotations and texts are left alone."""
    source = (ROOT / path).read_bytes()
    tree, lines = ast.parse(source), source.splitlines()
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
            old = lines[node.lineno - 1][node.col_offset : node.end_col_offset].decode()
            yield Mutant(path, node.lineno, node.col_offset, node.end_col_offset, old, text)


def run_default_tests(data: Path) -> None:
    """Record in a file which of them reach which line."""
    packages = [f"--cov={package}" for package in PACKAGES]
    options = ["-q", "-n", "auto", "--cov-context=test", "--cov-report=", *packages]
    command = [sys.executable, "-m", "pytest", *options]
    environment = os.environ | {"COVERAGE_FILE": str(data)}
    subprocess.run(command, cwd=ROOT, env=environment, check=True)


def names_set_at(mutant: Mutant) -> set[str]:
    """Return the names that a statement of a module or class assigns on a mutant's line."""
    return {
        name.id
        for node in ast.walk(ast.parse((ROOT / mutant.path).read_text()))
        if isinstance(node, ast.Assign | ast.AnnAssign)
        and node.lineno <= mutant.line <= (node.end_lineno or 0)
        for target in (node.targets if isinstance(node, ast.Assign) else [node.target])
        for name in ast.walk(target)
        if isinstance(name, ast.Name)
    }


@cache
def contexts_of(path: Path, data: coverage.CoverageData) -> dict[int, list[str]]:
    return data.contexts_by_lineno(str(path))


def found_at(path: Path, lines: Iterable[int], data: coverage.CoverageData) -> set[str]:
    contexts = contexts_of(path, data)
    found = {context for line in lines for context in contexts.get(line, [])}
    return {context.partition("|")[0].partition("[")[0] for context in found} - {""}


def reaching(mutant: Mutant, data: coverage.CoverageData) -> list[str]:
    """Return the tests that may notice a mutant, those of its own module first.

    They are those that reach its line, and then all of its folder, because only the first test
    reaches a line whose outcome is cached. A line that only an import reaches has those that reach
    a line with a name that it sets, or else any line of its file. If there is none, because another
    process runs them, it has the tests of its own module, whatever their marks.
    """
    path = ROOT / mutant.path
    found = found_at(path, [mutant.line], data)
    if not found and (names := names_set_at(mutant)):
        word = re.compile(rf"\b({'|'.join(names)})\b")
        for file in sources():
            lines = enumerate(file.read_text().splitlines(), start=1)
            found |= found_at(file, [n for n, line in lines if word.search(line)], data)
    if not found:
        found = found_at(path, range(1, len(path.read_bytes().splitlines()) + 1), data)
    name = f"test_{path.stem}.py"
    own = [str(file.relative_to(ROOT)) for file in ROOT.glob(f"tests/**/{name}")]
    folder = Path("tests", str(Path(mutant.path).parent).replace("warehouse_", ""))
    while not (ROOT / folder).is_dir():
        folder = folder.parent
    if found:
        return [*sorted(found, key=lambda test: (name not in test, test)), str(folder)]
    return ["-m", "", *own] if own else [str(folder), "tests/system"]


class Copy:
    """A copy of the project in which pytest runs, with libraries that are loaded once."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        hidden = shutil.ignore_patterns(".*", "__pycache__")
        shutil.copytree(ROOT, folder, ignore=hidden)
        shutil.copytree(ROOT / ".github", folder / ".github")
        # Files are cached by their hash: a mutant may have the time and size of another.
        compileall.compile_dir(
            folder, quiet=1, invalidation_mode=py_compile.PycInvalidationMode.CHECKED_HASH
        )
        words = [sys.executable, ROOT / "tests" / "helpers" / "pytest_server.py", folder]
        self.server = subprocess.Popen(
            words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )

    def close(self) -> None:
        self.server.communicate()

    def run(self, tests: list[str]) -> tuple[int, list[str]]:
        """Run tests until one fails; return the exit code and which failed."""
        assert self.server.stdin is not None
        assert self.server.stdout is not None
        print(json.dumps([*OPTIONS, *tests]), file=self.server.stdin, flush=True)
        code, lines = json.loads(self.server.stdout.readline())
        failed = [
            line.partition(" ")[2] for line in lines if line.startswith(("FAILED ", "ERROR "))
        ]
        return code, [line.partition(" - ")[0].partition("[")[0] for line in failed]

    def run_with(self, mutant: Mutant, tests: list[str]) -> tuple[int, list[str]]:
        target = self.folder / mutant.path
        target.write_bytes(mutant.source())
        try:
            return self.run(tests)
        finally:
            shutil.copyfile(ROOT / mutant.path, target)


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
    copies, closing_all = SimpleQueue[Copy](), ExitStack()
    for number in range(os.cpu_count() or 1):
        one = Copy(tmp_path / str(number))
        closing_all.callback(one.close)
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
        is_noticed = code not in (0, -signal.SIGALRM)  # out of time is not noticed
        print(
            "noticed" if is_noticed else "missed", mutant, *failed, file=sys.__stdout__, flush=True
        )
        return is_noticed, failed

    with closing_all, ThreadPoolExecutor(copies.qsize()) as pool:
        tried = list(pool.map(try_one, some))
        # A test that fails without a mutant too notices nothing.
        failing = sorted({test for _, failed in tried for test in failed})
        assert not failing or one.run(["-m", "", *failing]) == (0, [])
    noticed = [is_good for is_good, _ in tried]
    share = sum(noticed) / len(some)
    measured(f"mutants noticed, of {len(some)} drawn from {len(all_mutants)}", f"{share:.1%}")
    missed = [str(mutant) for mutant, is_good in zip(some, noticed, strict=True) if not is_good]
    assert share >= LEAST_SHARE, missed
