"""The agent in a notebook: the classes in its cells, and what these need.

A notebook does more than to define an agent: it draws, trains and tries. So the cells are not run
as they are. Of their statements those count that define classes, and the imports, functions and
assignments of names that these use, directly or by others. All else is left out, also lines that
are commands of the notebook (``%`` and ``!``).

This module imports nothing but the standard library, and is loaded by a path: a notebook is parsed
in the process of its agent, under its limits.
"""

from __future__ import annotations

import ast
import json
from collections.abc import Iterator
from types import ModuleType

PYTHON = ("%%writefile", "%%file", "%%time", "%%capture")
"""Commands at the top of a cell whose further lines are Python."""

COMMANDS = ("%", "!", "?")
"""Beginnings of lines that are commands of the notebook."""

BINDING = (ast.FunctionDef, ast.AsyncFunctionDef, ast.Assign, ast.AnnAssign, ast.AugAssign,
           ast.Import, ast.ImportFrom)  # fmt: skip
"""Statements that count if a name that they bind is used."""


def cells_of(data: bytes) -> Iterator[tuple[int, str]]:
    """Yield the number of each cell of Python in a notebook, from 1, and its source.

    Raises:
        ValueError: it is no notebook in the form of nbformat 4.
    """
    try:
        cells = json.loads(data)["cells"]
        sources = [(each["cell_type"], "".join(each["source"])) for each in cells]
    except (LookupError, TypeError, ValueError, RecursionError):
        raise ValueError("it is no notebook (nbformat 4)") from None
    for number, (kind, source) in enumerate(sources, 1):
        first = source.lstrip().partition("\n")[0]
        is_command = first.startswith("%%")
        is_python = first.split(" ")[0] in PYTHON and (".py" in first or "file" not in first)
        if kind == "code" and (is_python or not is_command):
            yield number, "\n".join(map(_python_in, source.split("\n")))


def _python_in(line: str) -> str:
    """Return a line of a cell, or "" for a command of the notebook."""
    return "" if line.lstrip().startswith(COMMANDS) or line.endswith("?") else line


def trees_of(data: bytes, file: str) -> dict[str, ast.Module]:
    """Return the syntax tree of the agent in each cell that has a part of it, by its place."""
    trees = {}
    for number, source in cells_of(data):
        name = f"{file}, cell {number}"
        trees[name] = ast.parse(source, name)
    counted = _needed([each for tree in trees.values() for each in tree.body])
    for tree in trees.values():
        tree.body = [each for each in tree.body if each in counted]
    return {name: tree for name, tree in trees.items() if tree.body}


def _needed(statements: list[ast.stmt]) -> set[ast.stmt]:
    """Return the classes, and the statements that bind the names that they need."""
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
    """Return the names that a statement of ``BINDING`` binds; none of another."""
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
    """Run the agent in a notebook as a module."""
    module.__file__ = file
    with open(file, "rb") as opened:
        trees = trees_of(opened.read(), file)
    for place, tree in trees.items():
        exec(compile(tree, place, "exec"), vars(module))
