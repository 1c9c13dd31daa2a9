"""The command ``warehouse pogema``."""

import csv
import re
from pathlib import Path

import pytest
from helpers.command_line import Refused, Warehouse

from agents.lab.commands.pogema import results
from agents.lab.commands.pogema.benchmark import Kind
from agents.lab.commands.pogema.results import Key
from agents.lab.commands.pogema.summary import cell, groups_of, late_steps
from agents.lab.commands.pogema.trial import Outcome

SMALL = ("pogema", "random", "-r", 8, "-n", 2, "-j", 1)

ONE_SHOT = (*SMALL, "--kind", "one-shot", "--planner", "lacam", "-o", "values.csv")

MINE = """
from agents.errors import PlanError

def give_up(problem, seconds):
    raise PlanError("there may be a plan")

class Waits:
    def reset(self):
        pass

    def next_cells(self, situation):
        return situation.cells
"""


def outcomes(**values: list[Outcome]) -> dict[Key, Outcome]:
    """Return outcomes of planners in episodes from 0 of mazes with 64 robots."""
    return {
        Key(Kind.ONE_SHOT, "mazes", 64, number, planner, 2.0): each
        for planner, column in values.items()
        for number, each in enumerate(column)
    }


def lines() -> list[dict[str, str]]:
    with Path("values.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def test_planners_stand_beside_the_published_results_of_the_same_episodes(
    warehouse: Warehouse,
) -> None:
    code, out, err = warehouse(*SMALL, "--planner", "pibt", "-o", "values.csv")
    assert (code, err) == (0, "")
    assert out.startswith("4 episodes, 0 done\n")
    assert "LaCAM3" in out
    assert "RHCR" in out
    once, again = (
        [line for line in lines() if line["kind"] == kind] for kind in ("one-shot", "lifelong")
    )
    assert [line["map"] for line in once] == [f"validation-random-seed-00{n}" for n in (0, 1)]
    costs = [int(line["costs"]) for line in once]
    bounds = [int(line["bound"]) for line in once]
    # LaCAM3 has 82 and 72 there, and 82 is optimal.
    ratios = [costs[0] / 82, costs[1] / 72]
    assert all(1 <= cost / bound < 1.3 for cost, bound in zip(costs, bounds, strict=True))
    assert f"x {sum(ratios) / 2:.3f} ({max(ratios):.2f})" in out
    assert [line["steps"] for line in again] == ["256"] * 2
    rate = sum(int(line["goals"]) for line in again) / 512
    assert f"{rate:.2f}" in out


def test_a_proved_optimum_is_told(warehouse: Warehouse) -> None:
    out = warehouse(*SMALL, "-n", 1, "--planner", "cbs", "-o", "values.csv").out
    [line] = lines()
    assert (line["costs"], line["proved"]) == ("82", "1")
    assert out.count(" optimal") == 1
    assert "1 optimal" in out


def test_the_same_command_does_what_is_missing(warehouse: Warehouse) -> None:
    warehouse(*ONE_SHOT)
    path = Path("values.csv")
    head, first, second = path.read_text().splitlines()
    path.write_text(f"{head}\n{first.replace(',lacam,', ',kept,')}\n{first}\n{second[:30]}")
    out = warehouse(*ONE_SHOT).out
    assert out.startswith("2 episodes, 1 done\n")
    assert [(line["planner"], line["episode"]) for line in lines()] == [
        ("kept", "0"), ("lacam", "0"), ("lacam", "1"),
    ]  # fmt: skip
    assert path.read_text().splitlines()[3].split(",")[:-1] == second.split(",")[:-1]


def test_results_of_another_program_are_not_mixed(
    warehouse: Warehouse, refused: Refused, monkeypatch: pytest.MonkeyPatch
) -> None:
    warehouse(*ONE_SHOT)
    monkeypatch.setattr(results, "program_of", lambda planner: "another program")
    line = refused(*ONE_SHOT)
    assert line.startswith("values.csv: the episodes of planner 'lacam' were run by warehouse-lab ")
    assert line.endswith(" would be run by another program; write to another file")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a,b\n1,2\n", "values.csv: it was not written by warehouse pogema"),
        ("{head}\nx,y\n", "values.csv, line 2: it has 2 fields; needed: {width}"),
        ("{head}\n{line}x\n", "values.csv, line 2: could not convert string to float: '{end}x'"),
    ],
)
def test_a_file_of_other_results_is_refused(
    text: str, message: str, warehouse: Warehouse, refused: Refused
) -> None:
    warehouse(*ONE_SHOT)
    head, line, _ = Path("values.csv").read_text().splitlines()
    Path("values.csv").write_text(text.format(head=head, line=line))
    expected = message.format(width=head.count(",") + 1, end=line.rpartition(",")[2])
    assert refused(*ONE_SHOT) == expected


def test_solvers_of_a_user_run_one_shot_episodes_and_planners_of_steps_lifelong_ones(
    warehouse: Warehouse,
) -> None:
    Path("mine.py").write_text(MINE)
    names = ("--planner", "mine.py:Waits", "--planner", "mine.py:give_up")
    code, _, err = warehouse(*SMALL, *names, "-o", "values.csv")
    assert (code, err) == (0, "")
    assert {(line["kind"], line["planner"], line["steps"], line["goals"]) for line in lines()} == {
        ("one-shot", "mine.py:give_up", "-1", "0"),
        ("lifelong", "mine.py:Waits", "256", "0"),
    }


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("mazee",), "no set is called 'mazee'; allowed: random, mazes, warehouse, movingai, "),
        (("mazes", "-r", 63), "--robots has 63; allowed: 8, 16, 24, 32, 48, 64, as in the "),
        (("puzzles",), "the maps of 05-puzzles are read from a copy of the benchmark; give its"),
        (("mazes", "--planner", "nobody"), "no planner is called 'nobody'; allowed: pibt, "),
        (
            ("mazes", "--planner", "lacam", "--kind", "lifelong"),
            "no planner of --planner runs episodes that are lifelong",
        ),
    ],
)
def test_what_cannot_be_run_is_named(
    words: tuple[object, ...], message: str, warehouse: Warehouse
) -> None:
    result = warehouse("pogema", *words, "-n", 1)
    assert result.code in (1, 2)
    assert result.err.startswith(f"warehouse: {message}")


def test_sets_whose_maps_are_not_there_are_left_out_and_named(warehouse: Warehouse) -> None:
    words = ("-r", 8, "-n", 1, "-j", 1, "--kind", "one-shot", "--planner", "lacam")
    _, out, err = warehouse("pogema", *words)
    assert err.startswith("warehouse: movingai and puzzles are left out: their maps are in github")
    assert out.startswith("2 episodes, 0 done\n")


def test_a_plan_beyond_the_limit_of_steps_is_none(warehouse: Warehouse) -> None:
    plan = Outcome(128, 2000, 1000, 0, 0, 0, 1.0)
    values = {"in_time": [plan], "late": [plan._replace(steps=129)],
              "none": [plan._replace(steps=-1)]}  # fmt: skip
    [group] = groups_of(outcomes(**values))
    assert [cell(group, name).split("\n")[0] for name in values] == ["1 of 1", "0 of 1", "0 of 1"]


def test_ratios_are_over_episodes_that_both_solve() -> None:
    solved = [Outcome(100, costs, 1000, 0, 0, 0, 0.5) for costs in (1500, 2800, 1400)]
    [group] = groups_of(outcomes(mine=[*solved[:2], solved[2]._replace(steps=-1)]))
    reference = group.scores["LaCAM3"].values
    ratios = [1500 / reference[0], 2800 / reference[1]]
    words = f"2 of 3\n2.150\nx {sum(ratios) / 2:.3f} ({max(ratios):.2f})\n0.500 s"
    assert cell(group, "mine") == words
    first = group._replace(scores={**group.scores, "mine": group.scores["mine"]})
    first.scores["LaCAM3"].values[0] = float("inf")
    assert f"x {ratios[1]:.3f} ({ratios[1]:.2f})" in cell(first, "mine")


def test_optimal_plans_and_late_steps_are_counted() -> None:
    plan = Outcome(10, 1000, 1000, 1, 0, 2, 0.5)
    [group] = groups_of(outcomes(mine=[plan, plan._replace(proved=0)]))
    assert "1 optimal" in cell(group, "mine")
    [line] = late_steps([group])
    assert line.startswith("warning: mine, mazes, 64 robots: 4 steps took more than --plan-")


def test_the_page_has_curves_beside_the_published_ones_and_the_table(warehouse: Warehouse) -> None:
    words = ("pogema", "random", "-r", "8,16", "-n", 1, "-j", 1, "--planner", "lacam")
    assert "saved page.html" in warehouse(*words, "-o", "page.html").out
    page = Path("page.html").read_text()
    assert "lacam solves 2 of 2 one-shot episodes, LaCAM3 2; where both do, it has 1." in page
    assert page.count("<figure>") == 3
    row = "".join(rf"<td[^>]*>{cell}</td>" for cell in ("random", "16", "LaCAM3", "1 of 1"))
    assert re.search(row, page)
