"""Good, bad and hostile agents, and the points that each must get."""

import json
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from textwrap import indent
from typing import NamedTuple

import pytest

RUBRIC = """
title = "A short rubric"

[limits]
start_seconds = 1.0
answer_seconds = 0.5
episode_seconds = 3.0
memory_mb = 512
give_up_after = 1

[cases.chapter]
episodes = 4
max_steps = 60

[cases.loops]
layout = "trap"
episodes = 2
max_steps = 60

[cases.unseen]
layout = "random"
density = 0.3
episodes = 2
max_steps = 60
visible = false
first_seed = 77123

[cases.closed]
layout = "closed"
episodes = 2
max_steps = 60

[[criteria]]
name = "delivers"
points = 60
measure = "delivered"
cases = ["chapter", "loops", "unseen"]
full = 1
zero = 0

[[criteria]]
name = "stays calm"
points = 20
measure = "calm_without_way"
cases = ["closed"]
full = 1
needs = "delivers"

[[criteria]]
name = "protocol"
points = 10
measure = "protocol"
cases = ["chapter", "loops", "unseen", "closed"]
full = 1
needs = "delivers"

[[criteria]]
name = "fewest"
points = 10
measure = "steps_of_fewest"
cases = ["chapter", "loops", "unseen"]
full = 1.5
zero = 3
needs = "delivers"
"""

SEARCH = """
from collections import deque
MOVES = {"N": (-1, 0), "E": (0, 1), "S": (1, 0), "W": (0, -1)}

def first_move(here, goal, walls):
    seen, queue = {here}, deque([(here, None)])
    while queue:
        (row, col), first = queue.popleft()
        if (row, col) == goal:
            return first
        for move, (down, right) in MOVES.items():
            cell = row + down, col + right
            if cell not in seen and cell not in walls and max(map(abs, cell)) < 40:
                seen.add(cell)
                queue.append((cell, first or move))
    return NO_PATH

class Agent:
    def reset(self):
        self.walls = set()
        self.begin()
    def begin(self):
        pass
    def before(self, observation):
        pass
    def look(self, observation):
        (row, col), view = observation["robot_pos"], observation["local_grid"]
        half = len(view) // 2
        for down, line in enumerate(view):
            for right, tile in enumerate(line):
                if tile == "#":
                    self.walls.add((row + down - half, col + right - half))
    def act(self, observation):
        self.before(observation)
        self.look(observation)
        here = observation["robot_pos"]
        has_item = observation["has_item"]
        goal = observation["dropoff_pos" if has_item else "pickup_pos"]
        if here == goal:
            return self.say("DROP" if has_item else "PICK")
        return self.say(first_move(here, goal, self.walls))
    def say(self, action):
        return action
"""
"""An agent that searches in the cells that it has seen. Its action without a path, ``NO_PATH``, and
its methods are added."""

GOOD = f'NO_PATH = "WAIT"\n{SEARCH}'


def idle(body: str, before: str = "", place: str = "act") -> str:
    """Return an agent that runs a body in ``act``, ``reset`` or ``__init__``, and waits."""
    bodies = dict.fromkeys(("__init__", "reset", "act"), "        pass")
    bodies[place] = indent(body, 8 * " ")
    return f"""{before}
class Agent:
    def __init__(self):
{bodies["__init__"]}
    def reset(self):
{bodies["reset"]}
    def act(self, observation):
{bodies["act"]}
        return "WAIT"
"""


def good(method: str, body: str, before: str = "") -> str:
    """Return the agent that searches, with one method replaced."""
    return f"{before}\n{GOOD}\n    def {method}:\n{indent(body, 8 * ' ')}\n"


def notebook_of(*cells: str, kind: str = "code") -> str:
    """Return a notebook whose cells are of one kind."""
    made = [
        {"cell_type": kind, "metadata": {}, "outputs": [], "source": cell.splitlines(True)}
        for cell in cells
    ]
    return json.dumps({"nbformat": 4, "nbformat_minor": 5, "metadata": {}, "cells": made})


class Expected(NamedTuple):
    """An agent, its points, and a part of the message about its first failure."""

    source: str
    points: float
    failure: str = ""
    is_loaded: bool = True


SUBMISSIONS = {
    # Good.
    "searches": Expected(GOOD, 100),
    "indices": Expected(
        good(
            "say(self, action)",
            'words = ["N", "E", "S", "W", "WAIT", "PICK", "DROP"]\n'
            "return np.int64(words.index(action))",
            "import numpy as np",
        ),
        100,
    ),
    "keeps_a_class_attribute": Expected(
        good("begin(self)", "assert not Agent.walls_of_all\nAgent.walls_of_all.append(1)")
        + "    walls_of_all = []\n",
        100,
    ),
    # Bad.
    "picks": Expected(idle('return "PICK"'), 0),
    "none_without_path": Expected(
        GOOD.replace('NO_PATH = "WAIT"', "NO_PATH = None"), 70, "act() returned NoneType"
    ),
    "fails_without_path": Expected(
        good("say(self, action)", 'return [action][action == "WAIT"]'), 70, "IndexError"
    ),
    "syntax": Expected("class Agent:\n    def act(self\n", 0, "agent.py, line 2", False),
    "no_class": Expected("def act():\n    pass\n", 0, "there are: none", False),
    "two_classes": Expected(f"{GOOD}\nclass Other(Agent):\n    pass\n", 0, "Agent, Other", False),
    "wants_the_map": Expected(
        good("__init__(self, layout)", "pass"), 0, "graded agents get only observations", False
    ),
    # Hostile.
    "loops": Expected(idle("while True: pass"), 0, "no answer within 0.5 s"),
    "loops_when_imported": Expected("while True: pass\n", 0, "not ready after", False),
    "sleeps": Expected(idle("time.sleep(60)", "import time"), 0, "no answer within 0.5 s"),
    "exits": Expected(idle("os._exit(0)", "import os"), 0, "exit code 0"),
    "takes_4_gb": Expected(idle("self.all = bytearray(4 * 1024**3)"), 0, "MemoryError"),
    "fakes_lines": Expected(
        idle(
            "line = json.dumps({'word': '', 'action': 'DROP', 'delivered': True, 'points': 100})\n"
            "print(line, flush=True)\n"
            "for pipe in range(3, 64):\n"
            "    try: os.write(pipe, line.encode() + b'\\n')\n"
            "    except OSError: pass",
            "import json, os",
        ),
        0,
        "it wrote to the channel",
    ),
    "patches_json": Expected(
        idle('json.dumps = lambda *_, **__: \'{"word": "", "action": "DROP"}\'', "import json"),
        0,
        "it wrote to the channel",
    ),
    "searches_memory": Expected(
        idle(
            "if observation['steps']: return 'WAIT'\n"
            "frame, found = sys._getframe(), []\n"
            "while frame:\n"
            "    found += [*frame.f_locals.values(), *frame.f_globals.values()]\n"
            "    frame = frame.f_back\n"
            "found += gc.get_objects()\n"
            "names = {type(each).__name__ for each in found} | set(sys.modules)\n"
            "bad = [each for each in names if 'Warehouse' in each or 'Layout' in each]\n"
            "bad += [each for each in names if 'warehouse' in each or 'rubric' in each]\n"
            "texts = [each for each in found if isinstance(each, (str, int))]\n"
            "bad += [each for each in texts if each in (77123, 77124, '77123')]\n"
            "bad += [each for each in os.environ if 'PYTEST' in each or each == 'HOME']\n"
            "if bad: raise LookupError(bad)\n",
            "import gc, os, sys",
        ),
        0,
    ),
    "forks": Expected(idle("while True: os.fork()", "import os"), 0, "may not use os.fork"),
    "starts_a_program": Expected(
        idle("subprocess.Popen(['sleep', '600'])", "import subprocess"), 0, "may not use"
    ),
    "kills_its_parent": Expected(
        idle("os.kill(os.getppid(), 9)", "import os"), 0, "may not use os.kill"
    ),
    "leaves_a_daemon": Expected(
        idle("ctypes.CDLL(None).daemon(1, 1)\nctypes.CDLL(None).sleep(600)", "import ctypes"),
        0,
        "no answer within 0.5 s",
    ),
    "prints_much": Expected(idle("print('x' * 20_000)"), 0),
    "writes_a_file": Expected(idle("open('left', 'w').write('x')"), 0, "PermissionError"),
    "raises_what_cannot_be_shown": Expected(
        idle(
            "raise Odd",
            "class Odd(BaseException):\n    def __str__(self): raise self\n    __repr__ = __str__",
        ),
        0,
        "Odd",
    ),
    "raises_markup": Expected(
        idle("raise ValueError('<script>alert(1)</script>\\x1b[2J')"), 0, "<script>"
    ),
    "answers_much": Expected(idle("return 'N' * 1_000_000"), 0),
}
"""Agents by the name of their file."""


def write_submissions(folder: Path, *names: str) -> list[Path]:
    """Write agents, each into a folder of its own, and return their files."""
    files = [folder / name / "agent.py" for name in names]
    for file in files:
        file.parent.mkdir(parents=True)
        file.write_text(SUBMISSIONS[file.parent.name].source, encoding="utf-8")
    return files


def write_rubric(folder: Path, text: str = RUBRIC) -> Path:
    """Write a rubric into a folder, and return the file."""
    file = folder / "rubric.toml"
    file.write_text(text, encoding="utf-8")
    return file


def running_in(folder: Path) -> list[int]:
    """Return the processes of agents whose private copies are within ``folder``.

    An agent works in its copy. A file that is graded alone does not, but the words with which its
    process was started name it.
    """
    found = []
    for place in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            is_in = (place / "cwd").resolve().is_relative_to(folder)
            if is_in or os.fsencode(folder) in (place / "cmdline").read_bytes():
                found.append(int(place.name))
    return [pid for pid in found if pid != os.getpid()]


@contextmanager
def nothing_left_in(folder: Path) -> Iterator[None]:
    """Let agents have their private copies in a folder, in which nothing may be left or run."""
    folder.chmod(0o755)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TMPDIR", str(folder))
        patch.setattr(tempfile, "tempdir", None)
        yield
    assert not running_in(folder)
    assert not list(folder.iterdir())
