"""Runs the cells of a page, and prints what a notebook shows of them as text."""

import ast
import os
import sys
import warnings
from pathlib import Path

WRITE = "%%writefile "


def run_cell(source: str, names: dict[str, object]) -> None:
    """Run a cell; print the value of its last line, if that is an expression with a value."""
    if source.startswith(WRITE):
        head, _, text = source.partition("\n")
        Path(head.removeprefix(WRITE)).write_text(text, encoding="utf-8")
        return
    tree = ast.parse(source)
    last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, "cell", "exec"), names)
    if last is not None:
        value = eval(compile(ast.Expression(last.value), "cell", "eval"), names)
        if value is not None and not hasattr(value, "_repr_html_"):  # a player is no text
            print(value)


def run_cells(cells: list[str]) -> None:
    """Run the cells of a page in the current folder, with pictures that nobody sees."""
    warnings.simplefilter("ignore")  # that there are no threads is said once
    os.environ["MPLBACKEND"] = "agg"
    sys.path.insert(0, "")
    names: dict[str, object] = {"__name__": "__main__"}
    for number, source in enumerate(cells, 1):
        print(f"cell {number}")
        run_cell(source, names)
