"""The public objects of the packages, and the pages of the reference that describe them.

A public object is one that ``__all__`` of a package or a module names.
"""

import ast
import doctest
import importlib
import inspect
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from helpers.command_line import ROOT
from helpers.handbook import HANDBOOK

PACKAGES = ("warehouse_core", "warehouse_physics", "agents")
REFERENCE = HANDBOOK / "reference"
DIRECTIVE = re.compile(r"^\.\. auto(\w+):: (\S+)\n((?:   :.*\n)*)", re.MULTILINE)


class Public(NamedTuple):
    """An object, under the name by which a program imports it."""

    module: str
    name: str

    @property
    def value(self) -> Any:
        return getattr(importlib.import_module(self.module), self.name)

    @property
    def key(self) -> tuple[str, int]:
        """Key of the object, which is the same in all modules that export it."""
        return self.name, id(self.value)

    @property
    def docstring(self) -> str:
        """The docstring of the object itself; "" for constants and aliases."""
        return self.value.__doc__ or "" if self.is_described else ""

    @property
    def is_described(self) -> bool:
        """Whether it can have a docstring: classes and functions can."""
        value = self.value
        return inspect.isclass(value) or inspect.isfunction(inspect.unwrap(value))


@cache
def sources() -> dict[str, Path]:
    """Return the files of the packages by the names of their modules."""
    found = {}
    for package in PACKAGES:
        for path in sorted((ROOT / package).rglob("*.py")):
            parts = path.relative_to(ROOT).with_suffix("").parts
            found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


def exported_by(path: Path) -> list[str]:
    """Return the names in ``__all__`` of a file."""
    text = path.read_text(encoding="utf-8")
    for node in ast.parse(text).body if "__all__" in text else ():
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__":
            return list(ast.literal_eval(node.value))
    return []


@cache
def exports() -> dict[str, list[str]]:
    """Return the names in ``__all__`` of each package and module."""
    return {module: exported_by(path) for module, path in sources().items()}


def public_objects() -> list[Public]:
    """Return all objects that the packages and their modules export."""
    return [Public(module, name) for module, names in exports().items() for name in names]


def is_shown_with_its_module(each: Public) -> bool:
    """Return whether the directive of its module shows it, as it does for assigned constants."""
    text = sources()[each.module].read_text(encoding="utf-8")
    return each.is_described or re.search(rf"^{each.name}\b.* = ", text, re.MULTILINE) is not None


def objects_on(page: Path) -> Iterator[Public]:
    """Yield the objects that a page describes."""
    for kind, name, options in DIRECTIVE.findall(page.read_text(encoding="utf-8")):
        if kind != "module":
            yield Public(*name.rsplit(".", 1))
            continue
        [chosen] = re.findall(r":members:(.*)", options)
        words = chosen.replace(",", " ").split() or exports()[name]
        yield from filter(is_shown_with_its_module, (Public(name, word) for word in words))


def examples() -> dict[str, doctest.DocTest]:
    """Return the examples of each docstring that has any, by module and name."""
    parser, found = doctest.DocTestParser(), {}
    for module, path in sources().items():
        text = path.read_text(encoding="utf-8")
        for node in ast.walk(ast.parse(text)) if ">>> " in text else ():
            if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
                words, name = ast.get_docstring(node) or "", getattr(node, "name", "")
                place = f"{module}:{name}" if name else module
                test = parser.get_doctest(words, {}, place, str(path), 0)
                if test.examples:
                    assert place not in found, f"two examples of {place}"
                    found[place] = test
    return found
