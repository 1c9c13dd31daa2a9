"""The command ``warehouse compare agents``."""

from pathlib import Path

import pytest
from helpers.command_line import Warehouse
from PIL import Image

from agents.lab.commands import compare_agents
from agents.lab.commands.compare_agents import AGENTS
from agents.lab.trials.scores import EXPLANATION

SMALL = ("compare", "agents", "-n", 2, "--max-steps", 40)


def test_the_command_prints_a_row_for_each_agent_and_saves_a_figure(warehouse, monkeypatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    code, out, err = warehouse(*SMALL, "--seed", 5, "--save", "figure.png")
    assert (code, err) == (0, "")
    assert out.endswith("saved figure.png\n")
    with Image.open("figure.png") as picture:
        assert picture.width > 900
    others = [warehouse(*SMALL, "--seed", seed).out.splitlines() for seed in (5, 6)]
    assert others[0] == out.splitlines()[:-1]
    assert others[0][1:] != others[1][1:], "the title has the seed"
    assert "2 episodes each, backend grid, seeds from 5, random stations" in out
    lines = out.splitlines()
    names = [line.split("\u2502")[1].strip() for line in lines if line.startswith("\u2502")]
    assert list(filter(None, names)) == 2 * list(AGENTS.values())
    assert max(map(len, lines)) <= 80
    assert EXPLANATION in out.replace("\n", " ")
    assert "none" not in "".join(line for line in lines if "A*" in line)


def test_the_options_set_the_start_and_the_stations(warehouse: Warehouse, monkeypatch) -> None:
    tasks = []
    monkeypatch.setattr(
        compare_agents, "evaluate_watched", lambda _, __, task, ___: tasks.append(task)
    )
    monkeypatch.setattr(compare_agents, "scores_tables", lambda *_: [])
    Path("hall.txt").write_text("P.D.\n")
    for words in ([], ["--start", "0,1"], ["--stations", "drawn"]):
        assert warehouse(*SMALL, "--layout", "hall.txt", *words).code == 0
    places = list(dict.fromkeys((task.start_pos, task.randomize) for task in tasks))
    assert places == [(None, "start"), ((0, 1), False), (None, True)]


def test_the_figure_is_saved_even_if_the_output_is_closed(monkeypatch: pytest.MonkeyPatch) -> None:
    def leave(_: object) -> None:
        raise BrokenPipeError

    monkeypatch.setattr(compare_agents, "print_table", leave)
    with pytest.raises(BrokenPipeError):
        compare_agents.compare_agents(
            episodes=1, backend="grid", max_steps=2, save=[Path("figure.svg")]
        )
    assert "<svg" in Path("figure.svg").read_text(encoding="utf-8")
