"""The command ``warehouse compare-agents``."""

from pathlib import Path

import pytest
from helpers.command_line import command, refusal
from PIL import Image

from agents.lab.commands import compare_agents
from agents.lab.commands.compare_agents import AGENTS
from agents.lab.trials.scores import EXPLANATION

SMALL = ("compare-agents", "-n", 2, "--backend", "grid", "--max-steps", 40)


def test_the_command_prints_a_row_for_each_agent(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    code, out, err = command(capsys, *SMALL, "--seed", 5)
    assert (code, err) == (0, "")
    assert "2 episodes each, backend grid, seeds from 5, stations drawn" in out
    lines = out.splitlines()
    names = [line.split("\u2502")[1].strip() for line in lines if line.startswith("\u2502")]
    assert list(filter(None, names)) == 2 * list(AGENTS.values())
    assert max(map(len, lines)) <= 80
    assert EXPLANATION in out.replace("\n", " ")
    assert "none" not in "".join(line for line in lines if "A*" in line)


def test_the_same_seeds_give_the_same_table(capsys: pytest.CaptureFixture[str]) -> None:
    tables = [command(capsys, *SMALL, "--seed", seed).out for seed in (1, 1, 2)]
    rows = [table.partition("\n")[2] for table in tables]  # the title has the seed
    assert rows[0] == rows[1] != rows[2]


MINE = """
class Mine:
    def reset(self):
        self.steps = 0

    def act(self, observation):
        self.steps += 1
        if self.steps == 4:
            raise ValueError("too far")
        return "N"
"""


def test_agents_are_added_once_with_their_arguments(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("COLUMNS", "30")
    monkeypatch.chdir(tmp_path)
    Path("mine.py").write_text(MINE.replace("4", "-1"))
    more = [
        word for name in ("mine.py:Mine", "greedy:memory=3", "astar") for word in ("--agent", name)
    ]
    lines = command(capsys, *SMALL, *more).out.splitlines()
    names = [*AGENTS.values(), "mine.py:Mine", "greedy:memory=3"]
    assert [line for line in lines if line in names] == 2 * names


def test_the_options_set_the_start_and_the_stations(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    tasks = []
    monkeypatch.setattr(
        compare_agents, "evaluate_watched", lambda _, __, task, ___: tasks.append(task)
    )
    monkeypatch.setattr(compare_agents, "scores_tables", lambda *_: [])
    file = tmp_path / "hall.txt"
    file.write_text("P.D.\n")
    for words in ([], ["--start", "0,1"], ["--stations", "drawn"]):
        assert command(capsys, *SMALL, "--layout", file, *words).code == 0
    places = list(dict.fromkeys((task.start_pos, task.randomize) for task in tasks))
    assert places == [(None, "start"), ((0, 1), False), (None, True)]


def test_an_agent_that_fails_is_a_one_line_error_with_its_seed_and_step(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("mine.py").write_text(MINE)
    line = refusal(capsys, *SMALL, "--seed", 6, "--agent", "mine.py:Mine")
    assert line == "seed 6, step 4, agent mine.py:Mine: ValueError: too far (mine.py, line 9)"
    ran = []
    monkeypatch.setattr(compare_agents, "evaluate_watched", lambda *_: ran.append(1))
    assert "no class 'Yours'" in refusal(capsys, *SMALL, "--agent", "mine.py:Yours")
    assert not ran


def test_the_figure_is_saved_even_if_the_output_is_closed(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def leave(_: object) -> None:
        raise BrokenPipeError

    monkeypatch.setattr(compare_agents, "print_table", leave)
    with pytest.raises(BrokenPipeError):
        compare_agents.compare_agents(
            episodes=1, backend="grid", max_steps=2, save=tmp_path / "figure.svg"
        )
    assert (tmp_path / "figure.svg").exists()


@pytest.mark.parametrize("name", ["figure.png", "figure.svg"])
def test_the_figure_is_saved(capsys: pytest.CaptureFixture[str], tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    assert command(capsys, *SMALL, "--save", path).out.endswith(f"saved {path}\n")
    if path.suffix == ".png":
        with Image.open(path) as picture:
            assert picture.width > 900
    else:
        assert "<svg" in path.read_text(encoding="utf-8")


def test_a_file_that_cannot_be_written_is_an_error_before_the_episodes(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    line = refusal(capsys, *SMALL, "--save", tmp_path / "figure.gif")
    assert line == f"{tmp_path / 'figure.gif'}: cannot save as .gif; allowed: .svg, .png"
    assert "nowhere" in refusal(capsys, *SMALL, "--save", tmp_path / "nowhere" / "figure.png")


def test_invalid_options_are_errors(capsys: pytest.CaptureFixture[str]) -> None:
    assert "--episodes" in refusal(capsys, "compare-agents", "-n", 0, code=2)
    assert "antigravity" in refusal(capsys, "compare-agents", "--backend", "antigravity")
