"""Ctrl-C at any moment of any command: it must end with one line and exit code 130.

No process and no file may be left. ``MOMENTS=20 pytest tests/benchmarks/bench_interrupts.py``
interrupts 20 times. Each command runs in a process and a folder of its own. Moments are counted
from the first line of the program, because Python itself reports an interrupt while it starts.
"""

import os
import random
import shutil
import signal
import subprocess
import sys
import time
from itertools import cycle
from pathlib import Path
from typing import NamedTuple
from uuid import uuid4

from helpers.command_line import DISPLAY_VARIABLES, LEAVES

MOMENTS, SEED = int(os.environ.get("MOMENTS", "100")), 28
FIRST_SECONDS = 0.2
"""Time at the start of a command, in which it imports modules; every fourth moment is in it."""

MAX_SECONDS = 10.0
"""Maximum time from the start of a command to its interrupt."""

ENDING_SECONDS, GRACE_SECONDS = 20.0, 1.0
"""Time in which a command must end, and time in which its processes must have disappeared."""

MARK = "WAREHOUSE_INTERRUPTED"
"""Environment variable that identifies all processes of a command, because they inherit it."""

OF_TORCH = "torchinductor_"
"""Prefix of the name of an empty folder that PyTorch creates and keeps."""

PROGRAM = "from agents.__main__ import main; print('begun', flush=True); main()"

FLEET = "fleet --robots 8 --planner pibt --max-steps 150 --seed 1 --no-show"
COMMANDS = {
    "run --seed 1 --no-show": [],
    "run --seed 2 --backend physics --max-steps 40 --save a.gif --save b.html": ["a.gif", "b.html"],
    "run --seed 1 --save a.mp4": ["a.mp4"],
    "play": [],
    "demo slip --save a.gif": ["a.gif"],
    "replay lone.npz --save a.mp4": ["a.mp4"],
    "replay fleet.npz --save a.mp4": ["a.mp4"],
    "compare search --layout corridor --weights 1 --save a.gif": ["a.gif"],
    "run --agent exploring --seed 5 --save a.html --save b.svg": ["a.html", "b.svg"],
    f"{FLEET} --save a.npz --save b.html": ["a.npz", "b.html"],
    f"{FLEET} --backend driving --save a.npz": ["a.npz"],
    "plan --robots 32 --planner lacam --planner pibt --drive": [],
    "plan --robots 32 --planner lacam -o a.csv": ["a.csv"],
    "compare backends -r 4 --count 8 -n 1 -j 2 --save a.html --save b.csv": ["a.html", "b.csv"],
    "compare backends --robots 4 --count 8 -n 1 --jobs 1": [],
    "race --max-steps 40 --save a.html": ["a.html"],
    "sweep --set agent=greedy,astar -n 60 --jobs 2 -o a.sqlite": ["a.sqlite"],
    "sweep --set backend=grid,physics -n 20 --jobs 1 -o a.sqlite": ["a.sqlite"],
    "report results.sqlite -o a.html --figures .": ["a.html", "*.svg"],
    "grade mine.py --rubric rubric.toml --trust -o a.html": ["a.html"],
    "grade class --rubric rubric.toml --trust --jobs 2 --pages pages": [
        "grades.csv",
        "pages",
        "pages/*",
    ],
    "export results.sqlite a.csv": ["a.csv"],
    "export fleet.npz a.mcap": ["a.mcap"],
    "compare backends --seed 3 --save a.mp4": ["a.mp4"],
    "compare agents -n 10 --save a.png": ["a.png"],
    "compare planners --robots 8,16 -n 2 --lifelong 40 --jobs 2 --save a.svg": ["a.svg"],
    "train q --steps 6000 -o a.npz": ["a.*", "a.*/*"],
    "train ppo --steps 9000 -o a.npz": ["a.*", "a.*/*"],
    "layout random:height=40,width=60 -o a.txt": ["a.txt"],
    "layout shelves: -o a.txt": ["a.txt"],
    "layout warehouse:10-20-10-2-1 -o a.txt": ["a.txt"],
    "layout hall.map -o a.txt": ["a.txt"],
    "layout trap --check": [],
    "layout": [],
    "layout trap": [],
}
"""Commands with small sizes, and the complete files that each of them may leave."""

AGENT = """
class Agent:
    def reset(self): pass
    def act(self, observation): return "WAIT"
"""
RUBRIC = """
title = "Deliver"
[cases.seen]
layout = "default"
episodes = 4
[[criteria]]
name = "delivers"
points = 10
measure = "delivered"
cases = ["seen"]
full = 1.0
zero = 0.1
"""


class Ended(NamedTuple):
    """The end of a command.

    Attributes:
        interrupted: true if it was interrupted, and false if it ended by itself.
        seconds: time from the interrupt to the end, or from the start without an interrupt.
        faults: descriptions of what went wrong.
    """

    interrupted: bool
    seconds: float
    faults: list[str]


def inputs(folder: Path) -> None:
    """Write the files that the commands read."""
    folder.mkdir()
    (folder / "mine.py").write_text(AGENT)
    (folder / "rubric.toml").write_text(RUBRIC)
    (folder / "hall.map").write_text("type octile\nheight 2\nwidth 3\nmap\n...\n@..\n")
    (folder / "class").mkdir()
    for name in "abcd":
        (folder / "class" / f"{name}.py").write_text(AGENT)
    for line in (
        "run --seed 1 --save lone.npz",
        f"{FLEET} --save fleet.npz",
        "sweep --set agent=greedy,astar --set battery=50,200 -n 25 --jobs 1 -o results.sqlite",
    ):
        words = [sys.executable, "-m", "agents", *line.split()]
        subprocess.run(words, cwd=folder, env=environment(), check=True, capture_output=True)


def environment(**more: str) -> dict[str, str]:
    plain = {name: each for name, each in os.environ.items() if name not in DISPLAY_VARIABLES}
    return plain | more


def processes_with(mark: str) -> list[str]:
    """Return the processes that have a mark in their environment."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            if f"{MARK}={mark}".encode() in (folder / "environ").read_bytes():
                found.append((folder / "cmdline").read_bytes().replace(b"\0", b" ").decode()[:100])
        except OSError:  # it has ended, or belongs to another user
            continue
    return found


def left_in(folder: Path, allowed: list[str], before: set[str]) -> list[str]:
    """Return the files and folders that are neither inputs nor allowed outputs."""
    names = {str(path.relative_to(folder)) for path in folder.rglob("*")}
    whole = {str(path.relative_to(folder)) for pattern in allowed for path in folder.glob(pattern)}
    return sorted(names - before - whole)


def interrupted(line: str, moment: float | None, given: Path, base: Path) -> Ended:
    """Run a command, interrupt it if a moment is given, and check what it leaves."""
    folder, scratch, mark = base / "work", base / "scratch", uuid4().hex
    for each in (folder, scratch):
        shutil.rmtree(each, ignore_errors=True)
    shutil.copytree(given, folder)
    scratch.mkdir()
    before = {str(path.relative_to(folder)) for path in folder.rglob("*")}
    out, err = base / "out", base / "err"
    with out.open("wb") as output, err.open("wb") as errors:
        process = subprocess.Popen(
            [sys.executable, "-c", PROGRAM, *line.split()],
            cwd=folder,
            env=environment(**{MARK: mark, "TMPDIR": str(scratch)}),
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=errors,
            start_new_session=True,
        )
        while not out.stat().st_size and process.poll() is None:
            time.sleep(0.001)
        begun = time.perf_counter()
        try:
            process.wait(moment)
        except subprocess.TimeoutExpired:  # like Ctrl-C in a terminal, which signals the group
            os.killpg(process.pid, signal.SIGINT)
        sent = time.perf_counter()
        try:
            process.wait(ENDING_SECONDS)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
    ended = time.perf_counter()
    text, code = err.read_text(), process.returncode
    # While Python shuts down, an interrupt ends it at once.
    by_itself = code in (0, -signal.SIGINT) or line == "play"
    faults = [f"stderr: {text}"] if (text.count("\n") != 1 or "interrupted" not in text) else []
    faults += [] if code == 130 else [f"exit code {code}"]
    faults = [] if by_itself else faults
    deadline = time.perf_counter() + GRACE_SECONDS
    while (left := processes_with(mark)) and time.perf_counter() < deadline:
        time.sleep(0.02)
    faults += [f"process: {each}" for each in left]
    faults += [f"file: {each}" for each in left_in(folder, COMMANDS[line], before)]
    rest = [path.name for path in scratch.iterdir() if not path.name.startswith(OF_TORCH)]
    faults += [f"temporary: {name}" for name in rest]
    return Ended(not by_itself, ended - (begun if by_itself else sent), faults)


def test_an_interrupt_is_one_line_and_leaves_nothing(tmp_path, measured) -> None:
    assert all(any(f"{line} ".startswith(f"{leaf} ") for line in COMMANDS) for leaf in LEAVES)
    given, stream = tmp_path / "given", random.Random(SEED)
    inputs(given)
    wholes, faults = {}, []
    for line in COMMANDS:
        whole = interrupted(line, None, given, tmp_path)
        wholes[line] = whole.seconds
        faults += [f"{line}: {each}" for each in whole.faults]
    slowest, taken, early = 0.0, 0, 0
    for number, line in enumerate(cycle(COMMANDS)):
        if taken == MOMENTS:
            break
        is_early = number % 4 == 0
        moment = stream.uniform(0, FIRST_SECONDS if is_early else min(wholes[line], MAX_SECONDS))
        ended = interrupted(line, moment, given, tmp_path)
        faults += (found := [f"{line} at {moment:.3f} s: {each}" for each in ended.faults])
        print("\n".join(found), end="", flush=True)
        if ended.interrupted:
            taken, early = taken + 1, early + is_early
            slowest = max(slowest, ended.seconds)
    measured(
        f"{MOMENTS} interrupts of {len(COMMANDS)} commands at random times",
        f"{early} of them in the first {FIRST_SECONDS:g} s; each command prints one line, exits "
        "with code 130, and leaves no process and no file; it ends after at most "
        f"{slowest:.2f} s; {len(faults)} faults",
    )
    assert not faults
