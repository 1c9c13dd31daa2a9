"""Submissions that are alike are pointed out; others are not."""

import ast
import re
from pathlib import Path
from zipfile import ZipFile

import pytest
from helpers.submissions import GOOD, SUBMISSIONS, notebook_of, write_rubric

from agents.lab.grading.copies import find_copies
from agents.lab.grading.rubric import load_rubric
from agents.lab.grading.submissions import Submission, in_folder

OTHER = '''
import heapq
STEPS = [("N", -1, 0), ("S", 1, 0), ("E", 0, 1), ("W", 0, -1)]
class Planner:
    """An agent that searches too, written by somebody else."""
    def reset(self):
        self.blocked = set()
    def plan(self, start, goal):
        heap, cost, back = [(0, start)], {start: 0}, {}
        while heap:
            _, cell = heapq.heappop(heap)
            if cell == goal:
                while back.get(cell, (start,))[0] != start:
                    cell, _ = back[cell]
                return back[cell][1]
            for move, down, right in STEPS:
                following = cell[0] + down, cell[1] + right
                if following in self.blocked or max(following) > 40 or min(following) < 0:
                    continue
                if cost[cell] + 1 < cost.get(following, 10**6):
                    cost[following], back[following] = cost[cell] + 1, (cell, move)
                    distance = abs(following[0] - goal[0]) + abs(following[1] - goal[1])
                    heapq.heappush(heap, (cost[following] + distance, following))
        return "WAIT"
    def act(self, seen):
        row, col = seen["robot_pos"]
        half = len(seen["local_grid"]) // 2
        self.blocked |= {
            (row + down - half, col + right - half)
            for down, line in enumerate(seen["local_grid"])
            for right, tile in enumerate(line) if tile == "#"
        }
        if seen["has_item"]:
            there = seen["dropoff_pos"]
            return "DROP" if (row, col) == there else self.plan((row, col), there)
        there = seen["pickup_pos"]
        return "PICK" if (row, col) == there else self.plan((row, col), there)
'''


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
