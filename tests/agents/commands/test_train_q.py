from pathlib import Path

import pytest
import typer
from helpers.command_line import command, refusal

from agents.commands.train import train_q
from agents.evaluation.samples import MakeAgent
from agents.learning import training
from agents.learning.q_table import load_table

ROOM = "#####\n#P.D#\n#...#\n#####\n"
app = typer.Typer(add_completion=False)
app.command()(train_q)


@pytest.fixture(autouse=True)
def room(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Work in a folder with a small layout, and examine little."""
    monkeypatch.setattr(training, "EXAM_SEEDS", training.EXAM_SEEDS[:5])
    monkeypatch.setattr(training, "FINAL_SEEDS", training.FINAL_SEEDS[:40])
    monkeypatch.chdir(tmp_path)
    Path("room.txt").write_text(ROOM)


WORDS = ("train", "q", "--layout", "room.txt", "--max-steps", 30)


def test_a_table_is_trained_and_run(capsys: pytest.CaptureFixture[str]) -> None:
    result = command(capsys, *WORDS, "--steps", 20_000)
    assert (result.code, result.err) == (0, "")
    assert " steps in " in result.out.splitlines()[0]
    assert result.out.splitlines()[1:3] == ["saved q.npz", "saved q.png"]
    assert "delivered           │     100.0% │" in result.out
    result = command(
        capsys, "run", "--agent", "q:q.npz", "--layout", "room.txt", "--seed", 3, "--no-show"
    )
    assert result.out.startswith("QAgent on the grid backend, seed 3\noutcome         delivered\n")


def test_the_seed_repeats_a_training(capsys: pytest.CaptureFixture[str]) -> None:
    for seed, name in ((3, "a.npz"), (3, "b.npz"), (4, "c.npz")):
        command(capsys, *WORDS, "--steps", 500, "--seed", seed, "--output", name)
    assert load_table("a.npz") == load_table("b.npz")
    assert load_table("a.npz") != load_table("c.npz")
    assert Path("a.png").read_bytes() != Path("c.png").read_bytes()


def test_battery_and_steps_are_those_of_the_training(capsys: pytest.CaptureFixture[str]) -> None:
    # With three steps nothing can be delivered, so nothing is worth more than the pick.
    for option in ("--battery", "--max-steps"):
        command(capsys, "train", "q", "--layout", "room.txt", option, 3, "--steps", 3000)
        assert max(max(values) for values in load_table("q.npz").values()) < 4.9


def test_the_share_of_deliveries_is_told_as_the_table_learns(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    told: list[float] = []
    watch = training.Training.watch

    def note(self: training.Training, steps: int, delivers: float, make: MakeAgent) -> None:
        told.append(delivers)
        watch(self, steps, delivers, make)

    monkeypatch.setattr(training.Training, "watch", note)
    command(capsys, *WORDS, "--steps", 3000)
    assert told[0] in (0, 1)
    assert all(0 < share < 1 for share in told[len(told) // 2 :])
    told.clear()
    command(capsys, "train", "q", "--layout", "room.txt", "--max-steps", 3, "--steps", 300)
    assert told == [0] * 100


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--output", "q.zip"], "q.zip: cannot save as .zip; allowed: .npz"),
        (["--output", "missing/q.npz"], "the folder missing does not exist"),
        (["--layout", "missing.txt"], "missing.txt: No such file or directory"),
        (["--layout", "tiny.txt"], "randomize needs two open cells"),
    ],
)
def test_what_cannot_be_trained_is_one_line(
    capsys: pytest.CaptureFixture[str], words: list[str], message: str
) -> None:
    Path("tiny.txt").write_text("###\n#.#\n###\n")
    assert message in refusal(capsys, "train", "q", *words)
    assert not list(Path().glob("q*"))


@pytest.mark.parametrize(
    "words", [["--steps", "0"], ["--seed", "-1"], ["--seed", str(2**32)], ["--battery", "0"]]
)
def test_wrong_usage_names_the_option(capsys: pytest.CaptureFixture[str], words: list[str]) -> None:
    for agent in ("q", "ppo"):
        assert words[0] in refusal(capsys, "train", agent, *words, code=2)
