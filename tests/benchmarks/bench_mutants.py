"""The share of small changes to the code, drawn at random, that make a test fail.

Each is tried in a copy of the project with the tests that reach its line, which coverage.py has
recorded for a run of the default tests, quickest first. ``MUTANTS`` is their number,
``MUTANTS_SEED`` draws others, and ``MUTANTS_IN`` limits them to files whose path contains one of
its words. ``MUTANTS_COVERAGE`` is the file of what is recorded, with times in an ``.xml`` beside
it; if it exists, it is read in place of a new run.

Why not mutmut: in its version 3.8, too, it leaves constants, properties and cached functions alone,
about an eighth of all mutants here and most in ``task/rules.py``. Cosmic-ray runs all tests for
each mutant.
"""

import ast
import json
import os
import random
import shutil
import subprocess
import sys
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path
from queue import SimpleQueue
from typing import NamedTuple
from xml.etree import ElementTree

import coverage
import pytest
from helpers import mutants_worker
from helpers.command_line import ROOT

PACKAGES = ("warehouse_core", "warehouse_physics", "agents")
NUMBER = int(os.environ.get("MUTANTS", 200))
SEED = int(os.environ.get("MUTANTS_SEED", 0))
WORDS = os.environ.get("MUTANTS_IN", "/").split()
SECONDS = 60
"""Time after which a test that hangs counts as failed."""

OPTIONS = [
    "-x", "-q", "-p", "no:cacheprovider",
    "-o", f"faulthandler_timeout={SECONDS}", "-o", "faulthandler_exit_on_timeout=true",
]  # fmt: skip

SOME = 40
"""Tests of which the files are collected first for a mutant that is run by an import."""

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

    def applied(self, source: bytes) -> bytes:
        """Return the source of its file with the change."""
        lines = source.splitlines(keepends=True)
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
    """Record in a file which of them reach which line, and in another how long they take."""
    packages = [f"--cov={package}" for package in PACKAGES]
    options = ["-q", "-n", "auto", "--cov-context=test", "--cov-report=", *packages]
    times = f"--junitxml={data.with_suffix('.xml')}"
    command = [sys.executable, "-m", "pytest", times, *options]
    environment = os.environ | {"COVERAGE_FILE": str(data)}
    subprocess.run(command, cwd=ROOT, env=environment, check=True)


class Recorded:
    """What a run of the default tests has recorded."""

    def __init__(self, data: Path) -> None:
        self._coverage = coverage.CoverageData(str(data))
        self._coverage.read()
        self._seconds = {
            f"{case.get('classname', '').replace('.', '/')}.py::{case.get('name')}": float(seconds)
            for case in ElementTree.parse(data.with_suffix(".xml")).iter("testcase")
            if (seconds := case.get("time"))
        }

    @cache  # noqa: B019
    def contexts(self, path: str) -> dict[int, set[str]]:
        """Return the tests that reach each line of a file; the empty one if it is imported."""
        lines = self._coverage.contexts_by_lineno(str(ROOT / path))
        return {line: {each.rpartition("|")[0] for each in tests} for line, tests in lines.items()}

    def tests(self, mutant: Mutant) -> tuple[list[str], list[str]]:
        """Return the tests that may notice a mutant, quickest first, and folders of others.

        The folder comes too because only the first test reaches a line whose outcome is cached. No
        test reaches a constant, or a line that another process runs: those have all tests that
        reach the file, and all of the package.
        """
        contexts = self.contexts(mutant.path)
        tests = contexts.get(mutant.line, set()) - {""}
        folder = Path("tests", str(Path(mutant.path).parent).replace("warehouse_", ""))
        while not (ROOT / folder).is_dir():
            folder = folder.parent
        folders = [f"{folder}/"]
        if not tests:
            tests = set().union(*contexts.values()) - {""}
            folders.append(f"{Path(*folder.parts[:2])}/")
        name = f"test_{Path(mutant.path).stem}.py"
        near = sorted(tests, key=lambda each: (name not in each, self._seconds.get(each, 0), each))
        return near, folders

    def is_imported(self, mutant: Mutant) -> bool:
        """Return whether its line is run by an import, before any test."""
        return "" in self.contexts(mutant.path).get(mutant.line, ())


class Worker:
    """A process in a copy of the project that runs tests on request."""

    def __init__(self, folder: Path, tests: Iterable[str] = ()) -> None:
        self.has_ended = False
        requests, self._requests = os.pipe()
        answers, mine = os.pipe()
        self._answers = os.fdopen(answers)
        command = [sys.executable, "-P", mutants_worker.__file__, str(requests), str(mine)]
        self._process = subprocess.Popen(
            [*command, *OPTIONS, *tests],
            cwd=folder, env=os.environ | {"PYTHONPATH": str(folder)},
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
            pass_fds=(requests, mine), start_new_session=True,
        )  # fmt: skip
        os.close(requests)
        os.close(mine)

    def run(self, tests: list[str], folders: list[str], changed: str = "") -> tuple[int, list[str]]:
        """Run tests until one fails; return the exit code and which failed."""
        request = json.dumps([changed, tests, folders])
        failed = []
        try:
            os.write(self._requests, f"{request}\n".encode())
        except BrokenPipeError:
            return self.end(), []
        for line in self._answers:
            word, _, text = line.rstrip("\n").partition(" ")
            if word == "code":
                return int(text), failed
            failed.append(text)
        return self.end(), failed

    def end(self) -> int:
        """Wait until the process has ended, as it does without requests; return its exit code."""
        if not self.has_ended:
            os.close(self._requests)
            self._answers.close()
            self.has_ended = True
        return self._process.wait()


class Copy:
    """A copy of the project in which pytest runs."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        shutil.copytree(ROOT, folder, ignore=shutil.ignore_patterns(".*", "__pycache__"))
        shutil.copytree(ROOT / ".github", folder / ".github")
        # Bytecode known by the hash of its source: a mutant may have the time and size of another.
        command = [sys.executable, "-m", "compileall", "-q", "--invalidation-mode", "checked-hash"]
        subprocess.run([*command, *PACKAGES], cwd=folder, check=True)
        self.worker = Worker(folder)

    def run_with(self, mutant: Mutant, recorded: Recorded) -> tuple[int, list[str]]:
        """Run tests with a mutant; return the exit code and which failed."""
        target = self.folder / mutant.path
        source = target.read_bytes()
        target.write_bytes(mutant.applied(source))
        tests, folders = recorded.tests(mutant)
        try:
            code = mutants_worker.NOT_APPLIED
            if not recorded.is_imported(mutant):
                code, failed = self.worker.run(tests, folders, mutant.path)
            if code == mutants_worker.NOT_APPLIED:
                code, failed = self.run_anew(tests[:SOME], [])
                if code in (pytest.ExitCode.OK, pytest.ExitCode.NO_TESTS_COLLECTED):
                    code, failed = self.run_anew(tests[SOME:], folders)
            return code, failed
        finally:
            target.write_bytes(source)
            if self.worker.has_ended:
                self.worker = Worker(self.folder)

    def run_anew(self, tests: list[str], folders: list[str]) -> tuple[int, list[str]]:
        """Run tests in a process that imports what is changed."""
        files = [*dict.fromkeys(test.partition("::")[0] for test in tests), *folders]
        if not files:
            return pytest.ExitCode.NO_TESTS_COLLECTED, []
        worker = Worker(self.folder, files)
        code, failed = worker.run(tests, folders)
        worker.end()
        return code, failed


def sources() -> list[Path]:
    return sorted(path for package in PACKAGES for path in ROOT.glob(f"{package}/**/*.py"))


def test_nearly_all_mutants_are_noticed(tmp_path, measured) -> None:
    paths = [str(path.relative_to(ROOT)) for path in sources()]
    chosen = [path for path in paths if any(word in path for word in WORDS)]
    all_mutants = [mutant for path in chosen for mutant in mutants_of(path)]
    some = random.Random(SEED).sample(all_mutants, min(NUMBER, len(all_mutants)))
    data = Path(os.environ.get("MUTANTS_COVERAGE", tmp_path / "coverage"))
    if not data.exists():
        run_default_tests(data)
    recorded = Recorded(data)
    copies = SimpleQueue[Copy]()
    for number in range(os.cpu_count() or 1):
        copies.put(Copy(tmp_path / str(number)))

    def try_one(mutant: Mutant) -> tuple[bool, list[str]]:
        copy = copies.get()
        try:
            code, failed = copy.run_with(mutant, recorded)
        finally:
            copies.put(copy)
        # The other standard output is captured by ``capsys``, which ``measured`` uses.
        is_noticed = code not in (pytest.ExitCode.OK, pytest.ExitCode.NO_TESTS_COLLECTED)
        word = "noticed" if is_noticed else "missed"
        print(word, mutant, *failed, file=sys.__stdout__, flush=True)
        return is_noticed, failed

    with ThreadPoolExecutor(copies.qsize()) as pool:
        tried = list(pool.map(try_one, some))
    # A test that fails without a mutant too notices nothing.
    failing = sorted({test for _, failed in tried for test in failed})
    worker, *others = [copies.get().worker for _ in range(copies.qsize())]
    assert [test for test in failing if worker.run([test], [])[0]] == []
    for each in (worker, *others):
        each.end()
    noticed = [is_good for is_good, _ in tried]
    share = sum(noticed) / len(some)
    measured(f"mutants noticed, of {len(some)} drawn from {len(all_mutants)}", f"{share:.1%}")
    missed = [str(mutant) for mutant, is_good in zip(some, noticed, strict=True) if not is_good]
    assert share >= LEAST_SHARE, missed
