"""Agents in notebooks: the classes in the cells, and the code that they need.

A notebook does more than define an agent: it also plots, trains and experiments. Therefore only
some statements of its cells run: definitions of classes, and the imports, functions and assignments
of names that these use, directly or indirectly. Everything else is ignored, including commands of
the notebook (lines that begin with ``%`` or ``!``).

A notebook is parsed in the process of its agent, under its limits. Therefore this module imports
only the standard library, and is loaded by its path.
"""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Iterator, Sequence
from tokenize import COMMENT, ENDMARKER, INDENT, NEWLINE, NL, TokenError, generate_tokens
from types import ModuleType

PYTHON = ("%%writefile", "%%file", "%%time", "%%capture")
"""Commands in the first line of a cell after which the other lines are Python."""

COMMAND = re.compile(r"\s*([%!?].*|[^\s#'\"]+\?\??\s*)")
"""Statements that are commands of the notebook, such as ``!pip install x`` and ``math.pi?``."""

ASSIGNED = re.compile(r"([\w\s.,*\[\]]+=\s*)[!%].*")
"""Assignments of the output of a command, such as ``files = !ls``."""

TIMED = re.compile(r"(\s*)%time\s+(?=\S)")
"""Command before a statement that runs."""

BINDING = (ast.FunctionDef, ast.AsyncFunctionDef, ast.Assign, ast.AnnAssign, ast.AugAssign,
           ast.Import, ast.ImportFrom)  # fmt: skip
"""Statements that run if a name that they bind is used."""


def cells_of(data: bytes) -> Iterator[tuple[int, str]]:
    """Yield the number (from 1) and the source of each Python cell in a notebook.

    Raises:
        ValueError: the file is not a notebook in format 4 of nbformat.
    """
    try:
        cells = json.loads(data)["cells"]
        sources = [(each["cell_type"], "".join(each["source"])) for each in cells]
    except (LookupError, TypeError, ValueError, RecursionError):
        raise ValueError("it is not a notebook (nbformat 4)") from None
    for number, (kind, source) in enumerate(sources, 1):
        first = source.lstrip().partition("\n")[0]
        is_command = first.startswith("%%")
        is_python = first.split(" ")[0] in PYTHON and (".py" in first or "file" not in first)
        if kind == "code" and (is_python or not is_command):
            yield number, "\n".join(_python_in(source.split("\n")))


def _python_in(lines: Sequence[str]) -> Iterator[str]:
    """Yield the lines of a cell, in which commands of the notebook do nothing.

    As in IPython, only a statement can be a command, not a line within a statement or a string.
    """
    first = 0
    while first < len(lines):
        line = TIMED.sub(r"\1", lines[first])
        command = COMMAND.fullmatch(line)
        assigned = ASSIGNED.fullmatch(line)
        last = first
        if assigned or command:
            while lines[last].endswith("\\") and last + 1 < len(lines):
                last += 1
            done = f"{assigned[1]}None" if assigned else re.sub(r"\S.*", "pass", line)
            yield from [done, *[""] * (last - first)]
        else:
            last += _length(line, lines, first) - 1
            yield from [line, *lines[first + 1 : last + 1]]
        first = last + 1


def _length(line: str, lines: Sequence[str], first: int) -> int:
    """Return the number of lines of the statement that begins with a line; 1 if it is not one."""
    after = (lines[number] for number in range(first + 1, len(lines)))
    following = (f"{each}\n" for part in ([line], after) for each in part)
    is_begun = False
    try:
        for token in generate_tokens(following.__next__):
            if token.type in (NEWLINE, ENDMARKER) or (token.type == NL and not is_begun):
                return token.start[0]
            is_begun = is_begun or token.type not in (COMMENT, INDENT, NL)
    except (TokenError, SyntaxError):
        pass
    return 1


def trees_of(data: bytes, file: str) -> dict[str, ast.Module]:
    """Return the syntax trees of the cells that define the agent, by the names of the cells."""
    trees = {}
    for number, source in cells_of(data):
        name = f"{file}, cell {number}"
        trees[name] = ast.parse(source, name)
    needed = _needed([each for tree in trees.values() for each in tree.body])
    for tree in trees.values():
        tree.body = [each for each in tree.body if each in needed]
    return {name: tree for name, tree in trees.items() if tree.body}


def _needed(statements: list[ast.stmt]) -> set[ast.stmt]:
    """Return the definitions of classes, and the statements that they need."""
    by_name: dict[str, list[ast.stmt]] = {}
    for each in statements:
        for name in _bound(each):
            by_name.setdefault(name, []).append(each)
    found = set[ast.stmt]()
    waiting = [
        each for each in statements
        if isinstance(each, ast.ClassDef) or "*" in _bound(each) or _is_from_future(each)
    ]  # fmt: skip
    while waiting:
        each = waiting.pop()
        if each not in found:
            found.add(each)
            for node in ast.walk(each):
                if isinstance(node, ast.Name):
                    waiting += by_name.get(node.id, [])
    return found


def _is_from_future(statement: ast.stmt) -> bool:
    return isinstance(statement, ast.ImportFrom) and statement.module == "__future__"


def _bound(statement: ast.stmt) -> set[str]:
    """Return the names that a statement binds; an empty set if it is not in ``BINDING``."""
    if not isinstance(statement, BINDING):
        return set()
    if isinstance(statement, ast.Import | ast.ImportFrom):
        return {each.asname or each.name.partition(".")[0] for each in statement.names}
    if isinstance(statement, ast.FunctionDef | ast.AsyncFunctionDef):
        return {statement.name}
    return {
        node.id for node in ast.walk(statement)
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
    }  # fmt: skip


def load(module: ModuleType, file: str) -> None:
    """Run the statements of the agent in a notebook, in the namespace of a module."""
    module.__file__ = file
    with open(file, "rb") as opened:
        trees = trees_of(opened.read(), file)
    for place, tree in trees.items():
        exec(compile(tree, place, "exec"), vars(module))
