"""The command ``warehouse train``; learning/test_ppo_training.py tests PPO itself."""

import pickle
import re
import sys
import time
from pathlib import Path
from typing import Any

import pytest
from helpers.command_line import Refused, Warehouse, in_the_background
from helpers.results_files import row, scores_of
from helpers.training import PROGRAM, shorten_exams
from PIL import Image

from agents.lab.commands import train
from agents.lab.commands.train import Training, comparison_table
from agents.lab.training import curve
from agents.lab.training.exams import ExamPoint
from agents.lab.trials.scores import Scores
from agents.lab.trials.task import Task
from agents.learning.learner import MakeAgent, WatchTraining
from agents.learning.q_table import load_table
from warehouse_core import Layout, Observation

ROOM = Layout(["#####", "#P.D#", "#...#", "#####"])
TASK = Task(max_steps=5)
WORDS = ("train", "q", "--layout", "room.txt", "--max-steps", 30)


@pytest.fixture(autouse=True)
def room(monkeypatch: pytest.MonkeyPatch) -> None:
    """Use a small layout and short exams."""
    shorten_exams(monkeypatch)
    ROOM.save("room.txt")


@pytest.fixture
def curves(monkeypatch: pytest.MonkeyPatch) -> list[list[ExamPoint]]:
    """Return a list that collects the points of learning curves, which are not drawn."""
    drawn: list[list[ExamPoint]] = []

    def draw(path: Path, name: str, title: str, points: list[ExamPoint], greedy: Scores) -> None:
        assert len(greedy.rows) == 4
        drawn.append(points)
        path.write_text(f"{name}: {title}")

    monkeypatch.setattr(curve, "save_learning_curve", draw)
    return drawn


class Waiter:
    def __init__(self, seed: int) -> None:
        pass

    def reset(self) -> None:
        pass

    def act(self, observation: Observation) -> str:
        return "WAIT"


class Learning:
    """A learner that calls ``watch`` after some steps, and may then raise an error."""

    def __init__(self, *steps: int, ends: type[BaseException] | None = None) -> None:
        self.steps, self.ends = list(steps), ends

    def learn(self, watch: WatchTraining) -> MakeAgent:
        while self.steps:
            watch(self.steps.pop(0), 0.5, Waiter)
        if self.ends:
            raise self.ends
        return Waiter

    def state(self) -> list[int]:
        return self.steps

    def restore(self, state: list[int]) -> None:
        self.steps = state


def trained(learning: Learning, name: str = "X", task: Task = TASK, steps: int = 1000) -> None:
    """Train an agent, and write two files."""
    writers = {".npz": write, ".zip": write}
    Training(name, task, steps, 7, Path("x.npz")).run(learning, writers, resume=False)


def write(path: Path) -> None:
    path.write_text("what was learned")


FILES = ["x.checkpoint", "x.csv", "x.npz", "x.png", "x.zip"]


def files() -> list[str]:
    return sorted(path.name for path in Path().glob("x*") if path.is_file())


# A training.


def test_the_files_are_written_and_reported(capsys, curves: list[list[ExamPoint]]) -> None:
    trained(Learning(500, 1020), "Waiting")
    out = capsys.readouterr().out
    first, *saved = out.splitlines()[:5]
    assert re.fullmatch(r"1,020 steps in \d+\.\d s, seed 7", first)
    assert saved == ["saved x.npz", "saved x.zip", "saved x.png", "saved x.csv"]
    assert files() == FILES
    header, *lines = Path("x.csv").read_text().splitlines()
    assert header == "steps,delivered,low,high,mean_episode_steps"
    assert [line.split(",")[0] for line in lines] == ["500", "1020"]
    assert lines[0].endswith(",5.0"), "every episode ends after 5 steps"
    assert Path("x.png").read_text() == "Waiting: Learning to deliver: Waiting, seed 7"
    assert [point.steps for point in curves[0]] == [500, 1020]
    assert "The same 4 random starts for all" in out
    assert re.search(r"Waiting +. +greedy", out)
    assert re.search(r"delivered +. +0.0%", out)


@pytest.mark.parametrize(
    ("kind", "steps", "is_saved"),
    [
        (KeyboardInterrupt, 300, True),
        (ZeroDivisionError, 300, False),
        (KeyboardInterrupt, 20, False),
    ],
)
@pytest.mark.usefixtures("curves")
def test_an_interrupt_saves_an_agent_that_was_examined_and_a_fault_does_not(
    capsys: pytest.CaptureFixture[str], kind: type[BaseException], steps: int, is_saved: bool
) -> None:
    Path("x.npz").write_text("from before")
    with pytest.raises(kind):
        trained(Learning(steps, steps + 10, ends=kind))
    assert (files() == FILES) == is_saved
    assert (Path("x.npz").read_text() == "from before") != is_saved
    # The agent after the last steps is saved, although the last exam was earlier.
    assert capsys.readouterr().out.startswith("310 of 1,000 steps in ") == is_saved


def test_the_agent_is_saved_before_the_comparison(curves, monkeypatch) -> None:
    def interrupted(*_: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(train, "comparison_table", interrupted)
    with pytest.raises(KeyboardInterrupt):
        trained(Learning(10), steps=10)
    assert files() == FILES


def test_the_table_also_compares_on_the_starts_where_all_deliver() -> None:
    def scores(*steps: int) -> Scores:
        return scores_of(
            [row(0, "delivered" if taken < 200 else "stalled", taken) for taken in steps]
        )

    table = comparison_table({"one": scores(10, 20, 30, 200), "other": scores(12, 200, 40, 80)})
    assert table.rows == [
        ("delivered", "75.0%", "75.0%"),
        ("steps to deliver", "20.00", "44.00"),
        ("  if all deliver", "20.00", "26.00"),
    ]
    [_, (_, none), _] = comparison_table({"none": scores(200)}).rows
    assert none == "none"


# Q-learning.


def test_a_table_is_trained_and_run(warehouse: Warehouse) -> None:
    result = warehouse(*WORDS, "--steps", 10_000)
    assert (result.code, result.err) == (0, "")
    assert result.out.splitlines()[1:3] == ["saved q.npz", "saved q.png"]
    assert "delivered        │     100.0% │" in result.out
    with Image.open("q.png") as picture:
        assert picture.width > 900
    run = ("run", "--agent", "q:q.npz", "--layout", "room.txt", "--seed", 3, "--no-show")
    out = warehouse(*run).out
    assert out.startswith(
        "QAgent on the grid backend, seed 3, stations of the layout\noutcome         delivered\n"
    )


# Interrupts, and what comes after them.

LONG = (*WORDS, "--steps", 10_000)


@pytest.mark.usefixtures("curves")
def test_a_training_that_is_resumed_ends_as_if_it_had_not_been_interrupted(warehouse) -> None:
    checkpoint = Path("a.checkpoint")
    with in_the_background(PROGRAM, *LONG, "-o", "a.npz") as process:
        while not checkpoint.exists():
            assert process.poll() is None
            time.sleep(0.001)
        process.terminate()
        out, err = process.communicate(timeout=60)
    assert (process.returncode, err) == (130, "warehouse: interrupted\n")
    assert re.match(r"[\d,]+ of 10,000 steps in ", out)
    assert "saved a.npz" in out
    resumed, whole = (warehouse(*LONG, *w) for w in (("--resume", "-o", "a.npz"), ("-o", "b.npz")))
    assert re.match(r"resumed after [\d,]+ of 10,000 steps\n", resumed.out)
    assert resumed.err == whole.err == ""
    assert load_table("a.npz")[0] == load_table("b.npz")[0]
    assert Path("a.csv").read_text() == Path("b.csv").read_text()


@pytest.mark.usefixtures("curves")
def test_a_checkpoint_is_of_the_same_training_and_whole(warehouse, refused) -> None:
    words = ("train", "q", "--steps", 300, "--max-steps", 30, "-o", "a.npz")
    begun = warehouse(*words, "--resume")
    assert begun.err == "a.checkpoint does not exist; the training starts from the beginning\n"
    path = Path("a.checkpoint")
    assert "seed was 1 and is 2 now" in refused(*words, "--seed", 2, "--resume")
    assert "layout was " in refused(*words, "--layout", "room.txt", "--resume")
    content = path.read_bytes()
    path.write_bytes(content[:-1] + bytes([content[-1] ^ 1]))
    assert (
        refused(*words, "--resume")
        == "a.checkpoint: the file is damaged; its digest does not match"
    )
    path.write_bytes(pickle.dumps(0))
    assert refused(*words, "--resume").startswith(
        "a.checkpoint: its first line does not begin with"
    )


# PPO where PyTorch is missing.


def without(monkeypatch: pytest.MonkeyPatch, library: str) -> None:
    """Make the import of a library fail even if it is installed."""
    for name in ("ppo_training", "clone_training"):
        name = f"agents.learning.{name}"
        monkeypatch.delitem(sys.modules, name, raising=False)
    monkeypatch.setitem(sys.modules, library, None)


def test_a_missing_library_is_one_line_with_the_command_that_installs_it(
    refused: Refused, monkeypatch: pytest.MonkeyPatch
) -> None:
    without(monkeypatch, "torch")
    assert refused("train", "ppo") == (
        "training with PPO needs torch, which is not installed: pip install "
        "'sb3-contrib>=2.4' 'stable-baselines3>=2.4'"
    )
    assert refused("train", "clone").startswith(
        "training by imitation needs torch, which is not installed"
    )
    assert not [*Path().glob("ppo*"), *Path().glob("clone*")]
