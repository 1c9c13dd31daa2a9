"""Agents in notebooks: which statements of the cells run."""

import ast
from pathlib import Path
from types import ModuleType

import pytest
from helpers.submissions import notebook_of
from IPython.core.inputtransformer2 import TransformerManager

from agents.lab.grading.notebook import load, parse_cell

CELLS = (
    "import no_such_module\nimport math\n%matplotlib inline\n!pip install x\nmath.pi?",
    "MOVES = 'NESW'\nothers = no_such_name()\nindex: int = MOVES.index('E')",
    "def turn(move):\n    return MOVES[index]\ndef unused():\n    return others",
    "%%time\nraise SystemExit",
    "%%bash\nexit 1",
    "%%writefile my_agent.py\nclass Agent:\n    def act(self, seen):\n        return turn(seen)",
    "%%writefile notes.txt\nclass ( is no Python",
    "for _ in range(10**9):\n    Agent().act(None)",
)


def module_of(folder: Path, text: str) -> ModuleType:
    file = folder / "mine.ipynb"
    file.write_text(text, encoding="utf-8")
    module = ModuleType("mine")
    load(module, str(file))
    return module


def test_classes_count_and_what_they_need(tmp_path: Path) -> None:
    module = module_of(tmp_path, notebook_of(*CELLS))
    assert module.Agent().act(None) == "E"
    names = {name for name in vars(module) if not name.startswith("__")}
    assert names == {"MOVES", "index", "turn", "Agent"}


MIXED = '''%matplotlib inline
files = !ls
t = %timeit -o 1
a, b = !echo \\
   two
rest = (7
    % 4)  # is it?
text = """
!important
why?
"""
if rest:
    !pip install y
math.pi?
!echo it's
class Robot:
    %pip install x
    own = rest, text, t, {
        "percent": "a=%s" % rest,
    }
'''


def test_commands_are_found_where_ipython_finds_them(tmp_path: Path) -> None:
    """A remainder in a second line, a string and a comment are no commands."""
    ours = parse_cell(MIXED, "a cell").body
    theirs = ast.parse(TransformerManager().transform_cell(MIXED)).body
    assert len(ours) == 10
    for our, their in zip(ours, theirs, strict=True):
        is_command = "get_ipython" in ast.dump(their)
        assert is_command or ast.dump(our) == ast.dump(their), ast.unparse(their)
    module = module_of(tmp_path, notebook_of(MIXED))
    assert module.Robot.own == (3, "\n!important\nwhy?\n", None, {"percent": "a=3"})
    timed = module_of(tmp_path, notebook_of("%time x = 1  # really?\nclass A:\n    own = x"))
    assert timed.A.own == 1


def test_errors_name_the_cell_and_its_line(tmp_path: Path) -> None:
    with pytest.raises(SyntaxError) as caught:
        module_of(tmp_path, notebook_of("x = 1", "# y\nclass A\n    pass"))
    assert (Path(str(caught.value.filename)).name, caught.value.lineno) == (
        "mine.ipynb, cell 2", 2,
    )  # fmt: skip


@pytest.mark.parametrize("text", ["", "[]", '{"cells": 1}', '{"cells": [1]}', "[" * 100_000])
def test_what_is_no_notebook_is_refused(tmp_path: Path, text: str) -> None:
    with pytest.raises(ValueError, match="not a notebook"):
        module_of(tmp_path, text)
