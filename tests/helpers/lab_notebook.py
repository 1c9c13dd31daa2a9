"""The mini-lab as a notebook; ``python -m helpers.lab_notebook`` in ``tests`` writes it anew."""

import re
from pathlib import Path

import jupytext
from nbformat.v4 import new_code_cell

from helpers.handbook import HANDBOOK

PAGE = HANDBOOK / "mini_lab.md"
NOTEBOOK: Path = PAGE.with_suffix(".ipynb")

INSTALL_CELL = """
from importlib.util import find_spec

# If warehouse-lab is not installed, write the address of the repository ("git+https://...") or
# the path of a wheel that you have uploaded between the quotation marks.
SOURCE = ""
if find_spec("warehouse_core") is None:
    if not SOURCE:
        raise ValueError("write the address of the repository or the path of a wheel into SOURCE")
    %pip install --quiet "$SOURCE"
""".strip()

HIDDEN = re.compile(r"\s*<!--.*?-->", flags=re.DOTALL)
LINK = re.compile(r"(?<!!)\[([^\]]+)\]\((?!https?:)[^)]*\)")
"""Link to a page of the handbook, which a notebook that is opened alone does not have."""


def lab_notebook() -> str:
    """Return the text of the notebook: the cell that installs, then the page without its links."""
    notebook = jupytext.read(PAGE)
    notebook.metadata = {
        "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"}
    }
    notebook.cells.insert(0, new_code_cell(INSTALL_CELL))
    for number, cell in enumerate(notebook.cells):
        cell.id = f"cell-{number}"
        if cell.cell_type == "markdown":
            cell.source = LINK.sub(r"\1", HIDDEN.sub("", cell.source))
    return str(jupytext.writes(notebook, fmt="ipynb")) + "\n"


if __name__ == "__main__":
    NOTEBOOK.write_text(lab_notebook(), encoding="utf-8")
