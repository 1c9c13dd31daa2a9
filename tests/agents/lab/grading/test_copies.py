"""Submissions that are alike are pointed out; others are not."""

import ast
import re
from pathlib import Path
from zipfile import ZipFile

import pytest
from helpers.submissions import GOOD, SUBMISSIONS, notebook_of, write_rubric

from agents.lab.grading.copies import find_copies
from agents.lab.grading.rubric import SOLUTIONS, load_rubric
from agents.lab.grading.submissions import Submission, in_folder

OTHER = (SOLUTIONS / "exercise-13.py").read_text(encoding="utf-8")
"""An agent that searches too, written by somebody else."""


def renamed(source: str) -> str:
    """Return a source with other names, texts and comments, and its functions in another order."""
    names = "walls queue seen first goal row col here half view look begin before tile line"
    for name in names.split():
        source = re.sub(rf"\b{name}\b", f"my_{name}", source)
    head, first, rest = re.split(r"\n(?=def |class )", source)
    return f'"""Mine."""\n{head}\n{rest}\n\n# My own idea.\n{first}\n'


def alike(folder: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, str]:
    monkeypatch.setattr(ast, "parse", lambda *_: pytest.fail("the grader parses"))
    found = [each for each in in_folder(folder / "all", None) if isinstance(each, Submission)]
    return find_copies(found, load_rubric(folder / "rubric.toml"))


def test_renamed_copies_are_alike_in_every_form_and_others_are_not(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_rubric(tmp_path)
    (tmp_path / "all" / "many").mkdir(parents=True)
    copy = renamed(GOOD)
    for name, text in {
        "ann.py": GOOD, "bob.py": copy, "cells.ipynb": notebook_of(copy, "print('mine')"),
        "many/agent.py": copy, "many/more.py": "x = 1\n", "other.py": OTHER,
        "wrong.py": "class Agent:\n  def", "large.py": f"x = [{'0,' * 400_000}]",
        "greedy.py": SUBMISSIONS["greedy"].source, "random.py": SUBMISSIONS["random"].source,
        "waits.py": SUBMISSIONS["waits"].source,
    }.items():  # fmt: skip
        (tmp_path / "all" / name).write_text(text, encoding="utf-8")
    with ZipFile(tmp_path / "all" / "archive.zip", "w") as archive:
        archive.writestr("src/agent.py", copy)
    found = alike(tmp_path, monkeypatch)
    assert found.keys() == {"ann.py", "bob.py", "cells.ipynb", "many", "archive.zip"}
    assert found["bob.py"].startswith("many (100%), cells.ipynb (100%), archive.zip (100%)")


def test_what_the_starting_file_has_is_nobodys_and_ours_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_rubric(tmp_path)
    (tmp_path / "rubric.py").write_text(GOOD)
    (tmp_path / "all").mkdir()
    for name in ("ann.py", "bob.py"):
        (tmp_path / "all" / name).write_text(GOOD)
    own = Path(__file__).parents[4] / "agents" / "warehouse_agent_greedy.py"
    (tmp_path / "all" / "cat.py").write_text(own.read_text().replace("self", "this"))
    assert alike(tmp_path, monkeypatch) == {"cat.py": "agents/warehouse_agent_greedy.py (100%)"}
