"""What every training shares, with a learner that only pretends."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from agents.evaluation.samples import FIRST_EXAM_SEED, MakeAgent, Scores, Task
from agents.learning import training as module
from agents.learning.curve import Point
from agents.learning.training import EXAM_SEEDS, EXAMS, FINAL_SEEDS, Training, comparison_table
from warehouse_core import Observation
from warehouse_core.errors import FormatError

TASK = Task(max_steps=5)


class Waiter:
    """Learns nothing, and does nothing."""

    def reset(self) -> None:
        pass

    def act(self, observation: Observation) -> str:
        return "WAIT"


def waiter(seed: int) -> Waiter:
    return Waiter()


@pytest.fixture(autouse=True)
def few_starts(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(module, "EXAM_SEEDS", EXAM_SEEDS[:3])
    monkeypatch.setattr(module, "FINAL_SEEDS", FINAL_SEEDS[:4])
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def curves(monkeypatch: pytest.MonkeyPatch) -> list[list[Point]]:
    """Return a list to which the points of each learning curve are added."""
    drawn: list[list[Point]] = []

    def draw(path: Path, name: str, title: str, points: list[Point], greedy: Scores) -> None:
        assert len(greedy.steps) == 4
        drawn.append(points)
        path.write_text(f"{name}: {title}")

    monkeypatch.setattr(module, "save_learning_curve", draw)
    return drawn


def write(path: Path) -> None:
    path.write_text("what was learnt")


def learner(training: Training, *steps: int) -> Callable[[], MakeAgent]:
    """Return what looks like a learner that is watched after these numbers of steps."""

    def learn() -> MakeAgent:
        for taken in steps:
            training.watch(taken, 0.5, waiter)
        return waiter

    return learn


def files() -> list[str]:
    return sorted(path.name for path in Path().iterdir())


def test_examinations_are_spread_evenly_and_the_last_is_at_the_end(
    curves: list[list[Point]],
) -> None:
    training = Training("X", TASK, 1000, 1, Path("x.npz"))
    training.run(learner(training, *range(0, 1011, 10)), {".npz": write})
    steps = [point.steps for point in curves[0]]
    assert steps == [*range(40, 1001, 40), 1010]
    assert len(steps) == EXAMS + 1
    assert all(len(point.scores.steps) == 3 for point in curves[0])


def test_a_short_training_is_examined_once(curves: list[list[Point]]) -> None:
    training = Training("X", TASK, 1, 1, Path("x.npz"))
    training.run(learner(training, 0, 8192), {".npz": write})
    assert [point.steps for point in curves[0]] == [8192]


def test_what_comes_of_it_is_said_and_written(
    capsys: pytest.CaptureFixture[str], curves: list[list[Point]]
) -> None:
    training = Training("Waiting", TASK, 1000, 7, Path("x.npz"))
    training.run(learner(training, 500, 1020), {".npz": write, ".zip": write})
    first, *saved = capsys.readouterr().out.splitlines()[:4]
    assert re.fullmatch(r"1,020 steps in \d+\.\d s, seed 7", first)
    assert saved == ["saved x.npz", "saved x.zip", "saved x.png"]
    assert files() == ["x.npz", "x.png", "x.zip"]
    assert Path("x.png").read_text() == "Waiting: Learning to deliver: Waiting, seed 7"


def test_both_are_compared_on_the_same_starts(
    capsys: pytest.CaptureFixture[str], curves: list[list[Point]]
) -> None:
    training = Training("Waiting", TASK, 10, 1, Path("x.npz"))
    training.run(learner(training, 10), {".npz": write})
    out = capsys.readouterr().out
    assert "4 random starts, the same for each" in out
    assert re.search(r"Waiting +. +greedy", out)
    assert re.search(r"delivered +. +0.0%", out)


@pytest.mark.parametrize(
    ("kind", "left"), [(KeyboardInterrupt, ["x.npz", "x.png"]), (ZeroDivisionError, [])]
)
def test_an_interrupt_leaves_what_was_learnt_and_a_fault_nothing(
    capsys: pytest.CaptureFixture[str],
    curves: list[list[Point]],
    kind: type[BaseException],
    left: list[str],
) -> None:
    training = Training("X", TASK, 1000, 1, Path("x.npz"))

    def learn() -> MakeAgent:
        training.watch(300, 0.5, waiter)
        training.watch(310, 0.5, waiter)
        raise kind

    with pytest.raises(kind):
        training.run(learn, {".npz": write})
    assert files() == left
    assert capsys.readouterr().out.startswith("300 of 1,000 steps in ") == bool(left)


def test_an_interrupt_before_anything_was_examined_leaves_what_was_there(
    curves: list[list[Point]],
) -> None:
    Path("x.npz").write_text("from before")
    training = Training("X", TASK, 1000, 1, Path("x.npz"))

    def learn() -> MakeAgent:
        training.watch(20, 0.5, waiter)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        training.run(learn, {".npz": write})
    assert files() == ["x.npz"]
    assert Path("x.npz").read_text() == "from before"


def test_the_agent_is_safe_before_the_comparison(
    curves: list[list[Point]], monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(module, "comparison_table", interrupted)
    training = Training("X", TASK, 10, 1, Path("x.npz"))
    with pytest.raises(KeyboardInterrupt):
        training.run(learner(training, 10), {".npz": write})
    assert files() == ["x.npz", "x.png"]


@pytest.mark.parametrize("name", ["x.zip", "x", "x.NPZ", "x.png"])
def test_another_suffix_is_refused(name: str) -> None:
    with pytest.raises(FormatError) as refused:
        Training("X", TASK, 10, 1, Path(name))
    suffix = Path(name).suffix or "a file without a suffix"
    assert str(refused.value) == f"{name}: cannot save as {suffix}; allowed: .npz"


@pytest.mark.parametrize("suffix", [".npz", ".zip", ".png"])
def test_files_that_cannot_be_written_are_refused_before_anything_is_learnt(suffix: str) -> None:
    Path(f"x{suffix}").mkdir()
    for target, says in (("missing/x.npz", "the folder missing"), ("x.npz", f"x{suffix} is a")):
        training = Training("X", TASK, 10, 1, Path(target))
        with pytest.raises(OSError, match=says):
            training.run(lambda: pytest.fail("it learnt"), {".npz": write, ".zip": write})


def test_seeds_of_examinations_are_high_and_those_of_the_comparison_are_others() -> None:
    assert min(EXAM_SEEDS) >= FIRST_EXAM_SEED
    assert min(FINAL_SEEDS) >= FIRST_EXAM_SEED
    assert not set(EXAM_SEEDS) & set(FINAL_SEEDS)
    assert len(FINAL_SEEDS) >= 1000


def test_the_table_compares_on_what_all_delivered_too(capsys: pytest.CaptureFixture[str]) -> None:
    from rich.console import Console

    one = Scores(np.array([True, True, True, False]), np.array([10, 20, 30, 200]))
    other = Scores(np.array([True, False, True, True]), np.array([12, 200, 40, 80]))
    Console(width=80).print(comparison_table({"one": one, "other": other}))
    out = capsys.readouterr().out
    assert re.search(r"delivered +. +75.0% . +75.0%", out)
    assert re.search(r"steps to deliver +. +20.00 . +44.00", out)
    assert re.search(r"where all deliver +. +20.00 . +26.00", out)
