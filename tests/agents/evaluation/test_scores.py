"""How agents are compared: every one over the same seeds, and by what they did."""

import math
from typing import Any

import pytest

from agents.evaluation.figure import scores_figure
from agents.evaluation.scores import CONTENDERS, MEASURES, Run, Scores, Task, run_agent
from agents.search.agents import ExploringAgent
from warehouse_core import DEFAULT_LAYOUT, Layout
from warehouse_core.records.failure_modes import fewest_steps

TASK = Task(DEFAULT_LAYOUT, "grid", 200, 200)


def test_they_run_the_same_episodes() -> None:
    for seed in range(5):
        runs = {name: run_agent(make, TASK, seed) for name, make in CONTENDERS.items()}
        assert len({run.needed for run in runs.values()}) == 1
        assert runs["A*"].steps == runs["uniform-cost"].steps == runs["A*"].needed
        assert runs["A*"].expanded <= runs["uniform-cost"].expanded
        assert runs["greedy"].expanded == 0


def test_a_run_is_the_episode_that_the_command_run_shows() -> None:
    from agents.run_episode import run_episode

    episode = run_episode("greedy", "grid", seed=12)
    run = run_agent(CONTENDERS["greedy"], TASK, 12)
    [needed] = fewest_steps(episode.layout, (episode.cells[0], False))
    assert run == Run(
        episode.outcome == "delivered", episode.steps, float(needed or 0), episode.seconds,
        episode.joules, 0,
    )  # fmt: skip


def test_all_but_success_and_expansions_is_of_deliveries() -> None:
    good, bad = Run(True, 20, 10.0, 40.0, 900.0, 5), Run(False, 200, 10.0, 400.0, 9000.0, 95)
    scores = Scores([good] * 30 + [bad] * 10)
    found = [scores.steps, scores.ratio, scores.seconds, scores.joules, scores.expanded]
    assert [each and each.estimate for each in found] == [20, 2, 40, 900, pytest.approx(27.5)]
    assert scores.success.estimate == 0.75
    assert Scores([bad]).steps is None


def test_where_no_way_leads_there_is_no_fewest() -> None:
    layout = Layout(["########", "#..##..#", "#..##..#", "########"])
    runs = [run_agent(CONTENDERS["A*"], Task(layout, "grid", 9, 9), seed) for seed in range(20)]
    cut_off = [run for run in runs if math.isnan(run.needed)]
    assert cut_off
    assert not any(run.delivered for run in cut_off)


def test_the_figure_has_a_bar_for_each_agent_in_each_panel() -> None:
    good = Run(True, 20, 10.0, 40.0, 900.0, 5)
    figure = scores_figure({"one": Scores([good] * 30), "two": Scores([good] * 3)}, "A title")
    assert [axes.get_title(loc="left") for axes in figure.axes] == [each.title for each in MEASURES]
    widths = [[bar.get_width() for bar in axes.patches] for axes in figure.axes]
    assert widths == [[1, 1], [20, 20], [2, 2], [5, 5], [40, 40], [900, 900]]
    drawn = figure.get_tightbbox(figure.canvas.get_renderer())  # type: ignore[attr-defined]
    width, height = figure.get_size_inches()
    assert drawn.x0 >= 0
    assert drawn.x1 <= width
    assert drawn.y1 <= height


def test_an_agent_that_delivers_nothing_has_no_bar_for_it() -> None:
    bad = Run(False, 200, 10.0, 400.0, 9000.0, 95)
    figure = scores_figure({"one": Scores([bad] * 3)}, "")
    assert [len(axes.patches) for axes in figure.axes] == [1, 0, 0, 1, 0, 0]


def test_the_contenders_are_what_their_names_say() -> None:
    made: dict[str, Any] = {name: make(7, DEFAULT_LAYOUT) for name, make in CONTENDERS.items()}
    assert made["greedy"].seed == made["greedy without escape"].seed == 7
    assert made["greedy"].escape_steps > 0
    assert made["greedy without escape"].escape_steps == 0
    assert isinstance(made["exploring"], ExploringAgent)
    assert (made["uniform-cost"].algorithm, made["A*"].algorithm) == ("ucs", "astar")


def test_each_measure_is_the_one_that_its_column_names() -> None:
    scores = Scores([Run(True, 20, 10.0, 40.0, 900.0, 5)] * 3)
    found = {each.column: each.of(scores) for each in MEASURES}
    assert {name: interval and interval.estimate for name, interval in found.items()} == {
        "success": 1, "steps": 20, "of the fewest": 2, "expanded": 5, "seconds": 40, "joules": 900,
    }  # fmt: skip
