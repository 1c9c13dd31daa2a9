"""Agents that fail, take long or are interrupted, in an episode and in the command."""

import time
from pathlib import Path
from typing import Any

import pytest
from helpers.command_line import Warehouse
from PIL import Image

from agents.lab.commands.run import run_episode
from agents.lab.console import watch
from warehouse_core import Episode

AGENTS = """
class Base:
    def reset(self):
        self.count = 0

    def act(self, observation):
        self.count += 1
        return self.choose() if self.count == 3 else "N"

class Fails(Base):
    def choose(self):
        raise ValueError("too far")  # line 12

class Leaves(Base):
    def choose(self):
        raise SystemExit(3)  # line 16

class Silent(Base):
    def choose(self):
        return None

class Stopped(Base):
    def choose(self):
        raise KeyboardInterrupt  # line 24

class NeverStarts(Base):
    def reset(self):
        return self.missing  # line 28
"""


@pytest.fixture(autouse=True)
def agent_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, small_pictures: None) -> None:
    monkeypatch.chdir(tmp_path)
    Path("mine.py").write_text(AGENTS)


@pytest.mark.parametrize(
    ("name", "code", "line"),
    [
        ("Fails", 1, "seed 4, step 3, agent mine.py:Fails: ValueError: too far (mine.py, line 12)"),
        ("Stopped", 130, "interrupted in step 3, agent mine.py:Stopped (mine.py, line 24)"),
    ],
)
def test_the_episode_so_far_is_reported_and_saved(
    warehouse: Warehouse, name: str, code: int, line: str
) -> None:
    words = ("run", "--agent", f"mine.py:{name}", "--seed", 4, "--save", "e.npz")
    result = warehouse(*words)
    assert (result.code, result.err) == (code, f"warehouse: {line}\n")
    assert "outcome         unfinished\n" in result.out
    assert Episode.load("e.npz").actions == ["N", "N"]


def test_a_failure_is_replayed_up_to_its_step(warehouse: Warehouse) -> None:
    assert warehouse("run", "--agent", "mine.py:Fails", "--seed", 4).code == 1
    with Image.open("replay-Fails-grid-4.gif") as image:
        assert image.n_frames == 3  # type: ignore[attr-defined]


def test_each_step_that_takes_long_is_reported_once_with_its_line(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(watch, "SLOW_SECONDS", 0.05)
    monkeypatch.setattr(watch, "LOOK_SECONDS", 0.01)

    class Slow:
        def reset(self) -> None:
            self.count = 0

        def act(self, observation: Any) -> str:
            self.count += 1
            if self.count in (2, 4):
                time.sleep(0.4)
            return "N"

    line = Slow.act.__code__.co_firstlineno + 3
    monkeypatch.setattr("agents.lab.commands.run.make_agent", lambda *_: Slow())
    assert run_episode("slow", seed=1, max_steps=5).steps == 5
    assert capsys.readouterr().err.splitlines() == [
        f"warehouse: step {step}, agent slow takes more than 0.05 s (test_watch.py, line {line}); "
        "Ctrl-C ends it"
        for step in (2, 4)
    ]
