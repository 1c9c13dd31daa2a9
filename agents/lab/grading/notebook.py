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
from collections.abc import Iterator
from types import ModuleType

PYTHON = ("%%writefile", "%%file", "%%time", "%%capture")
"""Commands in the first line of a cell after which the other lines are Python."""

COMMANDS = (
    (re.compile(r"(\s*)%time\s+(\S.*)"), r"\1\2"),
    (re.compile(r"([\w\s.,*\[\]]+=\s*)[!%].*"), r"\1None"),
    (re.compile(r"(\s*)([%!?].*|[^\s#'\"]+\?\??\s*)"), r"\1pass"),
)
"""Lines that are commands of the notebook, with the Python that runs instead.

They are ``%time`` before a statement; assignments of an output, such as ``files = !ls``; and all
others, such as ``!pip install x`` and ``math.pi?``."""

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
            yield number, source


def parse_cell(source: str, name: str) -> ast.Module:
    """Return the syntax tree of a cell, in which commands of the notebook do nothing.

    Only a line that is wrong in Python can be a command, not one within a statement or a string.
    """
    lines = source.split("\n")
    while True:
        try:
            return ast.parse("\n".join(lines), name)
        except SyntaxError as error:
            place = min(error.lineno or 1, len(lines)) - 1
            line = lines[place]
            found = next((each for each in COMMANDS if each[0].fullmatch(line)), None)
            if found is None:
                raise
            lines[place] = found[0].sub(found[1], line)
            while line.endswith("\\") and place + 1 < len(lines):  # it continues
                place += 1
                line, lines[place] = lines[place], ""


def trees_of(data: bytes, file: str) -> dict[str, ast.Module]:
    """Return the syntax trees of the cells that define the agent, by the names of the cells."""
    trees = {}
    for number, source in cells_of(data):
        name = f"{file}, cell {number}"
        trees[name] = parse_cell(source, name)
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
