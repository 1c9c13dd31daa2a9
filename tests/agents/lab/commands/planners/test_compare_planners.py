"""The command ``warehouse compare-planners``."""

from functools import partial

import numpy as np
import pytest
from helpers.command_line import command, refusal
from PIL import Image

from agents.lab.commands.planners.compare_planners import (
    BOUND,
    Outcome,
    parse_sizes,
    run_trial,
    summary,
)
from agents.lab.commands.planners.floors import find_floor
from agents.lab.commands.planners.picture import throughput_figure
from agents.lab.trials.interval import Interval
from agents.lab.trials.workers import run_trials

SMALL = ("compare-planners", "--layout", "hall", "--robots", "4,2", "--steps", 30, "--jobs", 1)


run_in_hall = partial(run_trial, layout="hall", steps=30, seconds=10.0)


def test_planners_are_compared_by_size_beside_the_bound(
    capsys: pytest.CaptureFixture[str],
) -> None:
    code, out, err = command(capsys, *SMALL, "--seeds", 20, "--save", "curve.png")
    assert (code, err) == (0, "")
    assert "30 steps, 20 seeds from 0" in " ".join(out.split())
    assert out.index("2 \u2502") < out.index("4 \u2502")
    expected = np.mean([run_in_hall(("pibt", 4), seed).throughput for seed in range(20)])
    assert f" {expected:.2f} " in out
    assert out.count(" to ") == 4
    assert "saved curve.png" in out
    with Image.open("curve.png") as image:
        assert image.format == "PNG"


def test_a_picture_is_also_written_as_svg(capsys: pytest.CaptureFixture[str], tmp_path) -> None:
    assert command(capsys, *SMALL, "--seeds", 1, "--save", "curve.svg").code == 0
    assert (tmp_path / "curve.svg").read_text().startswith("<?xml")


def test_the_bound_is_more_than_any_planner_reaches_and_exact_for_one_robot() -> None:
    alone = [run_in_hall((name, 1), 0).throughput for name in ("pibt", BOUND)]
    assert alone[0] == alone[1] > 0
    crowded = [run_in_hall((name, 40), 0).throughput for name in ("pibt", BOUND)]
    assert crowded[0] < crowded[1]


def test_processes_give_the_same_as_one() -> None:
    cases = [("pibt", 3), ("pibt-lanes", 2)]
    alone, together = (run_trials(run_in_hall, cases, range(3, 6), jobs) for jobs in (1, 2))
    throughputs = [
        {case: [each.throughput for each in outcomes] for case, outcomes in found.items()}
        for found in (alone, together)
    ]
    assert throughputs[0] == throughputs[1]
    assert throughputs[0] == {
        case: [run_in_hall(case, seed).throughput for seed in (3, 4, 5)] for case in cases
    }


def test_outcomes_are_summed_up_with_an_interval() -> None:
    found = summary([Outcome(rate, 2.0, 1) for rate in np.linspace(1, 2, 20)])
    assert found.throughput.low < found.throughput.estimate == pytest.approx(1.5)
    assert (found.milliseconds, found.lost) == (2.0, 20)
    assert not summary([Outcome(1.0, 2.0, 0)]).throughput.is_known


def test_the_picture_has_a_line_for_each_planner_and_its_interval() -> None:
    curve = {8: Interval(1.0, 0.9, 1.1), 16: Interval(1.5, 1.4, 1.7)}
    bound = {8: Interval(2.0), 16: Interval(4.0)}
    figure = throughput_figure({"$a$": curve, BOUND: bound}, BOUND, "T")
    [axes] = figure.axes
    assert [list(line.get_ydata()) for line in axes.get_lines()] == [[1.0, 1.5], [2.0, 4.0]]
    intervals = axes.collections[0].get_segments()
    assert [each[:, 1].tolist() for each in intervals] == [[0.9, 1.1], [1.4, 1.7]]
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["$a$", BOUND]


@pytest.mark.parametrize(
    ("options", "words", "code"),
    [
        ("--robots 4,x", "--robots has 'x'; it must be whole numbers", 2),
        ("--robots 0", "--robots has '0'; it must be", 2),
        ("--robots 999", "--robots has 999; allowed: 1 to 98", 1),
        ("--planner x", "no planner is called 'x'; allowed: pibt, pibt-lanes", 1),
        ("--time-limit 0", "--time-limit is 0; it must be above 0 s", 2),
        ("--save a.gif", "cannot save as .gif; allowed: .svg, .png", 1),
    ],
)
def test_wrong_options_are_named(
    options: str, words: str, code: int, capsys: pytest.CaptureFixture[str]
) -> None:
    assert words in refusal(capsys, *SMALL, *options.split(), code=code)


def test_sizes_are_read_in_ascending_order() -> None:
    assert parse_sizes("64, 8,64") == [8, 64]


def test_planners_that_learn_know_the_goals_of_the_warehouse_of_papers() -> None:
    floor = find_floor(None)
    pickups = [row * floor.layout.width + col for row, col in floor.layout.pickups]
    assert pickups == floor.goals.tolist()
    assert not find_floor("depot").layout.pickups
