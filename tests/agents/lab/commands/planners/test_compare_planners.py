"""The command ``warehouse compare planners``."""

from functools import partial

import numpy as np
from helpers.command_line import Warehouse, write_mine
from PIL import Image

from agents.lab.commands.planners.compare_planners import (
    BOUND,
    run_trial,
)
from agents.lab.commands.planners.floors import find_floor
from agents.lab.commands.planners.picture import curves_figure
from agents.lab.trials.interval import Interval
from agents.lab.trials.workers import run_trials

SMALL = (
    "compare", "planners", "--layout", "hall", "--robots", "4, 2,4", "--lifelong", 30, "--jobs", 1,
)  # fmt: skip


run_in_hall = partial(run_trial, layout="hall", steps=30, seconds=10.0)


def test_planners_are_compared_by_size_beside_the_bound(warehouse: Warehouse) -> None:
    code, out, err = warehouse(*SMALL, "-n", 20, "--save", "curve.png")
    assert (code, err) == (0, "")
    assert "30 steps, 20 seeds from 0" in " ".join(out.split())
    assert out.index("2 \u2502") < out.index("4 \u2502")
    expected = np.mean([run_in_hall(("pibt", 4), seed).throughput for seed in range(20)])
    assert f" {expected:.2f} " in out
    assert out.count(" to ") == 4
    assert "Fewer" not in out
    assert "Fewer than 20 episodes have no intervals." in warehouse(*SMALL).out
    assert "saved curve.png" in out
    with Image.open("curve.png") as image:
        assert image.format == "PNG"


def test_the_bound_is_more_than_any_planner_reaches_and_exact_for_one_robot() -> None:
    alone = [run_in_hall((name, 1), 0).throughput for name in ("pibt", BOUND)]
    assert alone[0] == alone[1] > 0
    crowded = [run_in_hall((name, 40), 0).throughput for name in ("pibt", BOUND)]
    assert crowded[0] < crowded[1]


def test_processes_give_the_same_as_one() -> None:
    cases = [("pibt", 3), ("pibt-lanes", 2)]
    alone, together = (run_trials(run_in_hall, cases, range(3, 6), jobs) for jobs in (1, 2))
    for case in cases:
        expected = [run_in_hall(case, seed).throughput for seed in (3, 4, 5)]
        for outcomes in (alone, together):
            assert [each.throughput for each in outcomes[case]] == expected


def test_steps_that_took_too_long_are_told(warehouse: Warehouse) -> None:
    write_mine("next_cells", "while True: pass", "seen.cells", step=1)
    words = ("--planner", "mine.py:Mine", "--lifelong", 2, "--plan-seconds", 0.02, "-n", 2)
    code, _, err = warehouse(*SMALL, *words)
    assert code == 0
    assert err.splitlines() == [
        f"warehouse: warning: mine.py:Mine, {robots} robots: 4 steps took more than 0.02 s; "
        "all robots waited"
        for robots in (2, 4)
    ]


def test_the_picture_has_a_line_for_each_planner_and_its_interval() -> None:
    curve = {8: Interval(1.0, 0.9, 1.1), 16: Interval(1.5, 1.4, 1.7)}
    bound = {8: Interval(2.0), 16: Interval(4.0)}
    figure = curves_figure({"$a$": curve, BOUND: bound}, "T", "goals", BOUND)
    [axes] = figure.axes
    assert [list(line.get_ydata()) for line in axes.get_lines()] == [[1.0, 1.5], [2.0, 4.0]]
    intervals = axes.collections[0].get_segments()
    assert [each[:, 1].tolist() for each in intervals] == [[0.9, 1.1], [1.4, 1.7]]
    words = axes.get_legend().get_texts()
    assert [(text.get_text(), text.get_parse_math()) for text in words] == [
        ("$a$", False), (BOUND, False),
    ]  # fmt: skip


def test_many_numbers_of_robots_have_ticks_at_whole_numbers() -> None:
    [axes] = curves_figure({"a": {size: Interval(1.0) for size in range(1, 21)}}, "T", "goals").axes
    assert [tick for tick in axes.get_xticks() if tick % 1] == []


def test_planners_that_learn_know_the_goals_of_the_warehouse_of_papers() -> None:
    floor = find_floor(None)
    pickups = [row * floor.layout.width + col for row, col in floor.layout.pickups]
    assert pickups == floor.goals.tolist()
    assert not find_floor("depot").layout.pickups
