"""Games of 2026: actions of several ticks, delays, and plans of several steps."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from helpers.league import league_crowd, league_of

from agents.mapf.epibt import EPIBT
from agents.mapf.graph import Graph
from agents.mapf.league.checker import check_result, overlap, ticked_cells
from agents.mapf.league.delays import DelayDraw
from agents.mapf.league.entry import PlannedEntry, View, foreseen
from agents.mapf.league.executor import Executor
from agents.mapf.league.result import Result, read_result, write_result
from agents.mapf.league.rules import LETTERS
from agents.mapf.league.scheduler import Scheduler
from agents.mapf.league.simulator import PERIOD, play
from agents.mapf.league.tasks import LeagueTask
from warehouse_core import Layout
from warehouse_core.world.robot_runners import Delays, League

EAST, SOUTH = 1, 2


def play_ours(problem: League, ticks: int) -> Result:
    graph = Graph(problem.layout)
    entry = PlannedEntry(graph, EPIBT(graph), Scheduler(graph, problem.revealed))
    return play(problem, entry, ticks, seconds=1000)


def actions_of(*texts: str) -> np.ndarray:
    return np.array([[*map(LETTERS.index, text)] for text in texts])


def executor_of(
    rows: tuple[str, ...], cells: list[int], headings: list[int], ticks: int = 2
) -> Executor:
    return Executor(Graph(Layout(rows)), np.array(cells), np.array(headings), ticks)


def run(executor: Executor, delays: list[list[bool]]) -> list[str]:
    ticks = [executor.tick(np.array(each)) for each in delays]
    return ["".join(LETTERS[action] for action in column) for column in np.array(ticks).T]


def test_a_crowd_with_delays_keeps_the_rules(tmp_path: Path) -> None:
    problem = league_crowd()
    result = play_ours(problem, 400)
    assert result.finished > 16
    assert any(result.delays)
    assert check_result(problem, result) == ("", result.finished)
    path = tmp_path / "r.json"
    write_result(path, result, problem.layout)
    read = read_result(path, problem.layout)
    assert np.array_equal(read.actual, result.actual)
    assert (read.ticks, read.delays) == (3, result.delays)
    assert check_result(problem, read) == ("", result.finished)


def test_actions_take_ticks_and_delays_pause_them() -> None:
    executor = executor_of(("...",), [0], [EAST])
    executor.stage(actions_of("FWR"))
    assert executor.passed == [[0, 1]]
    free, delayed = [False], [True]
    assert run(executor, [free, delayed, delayed, free, free]) == ["FWWFR"]
    assert (executor.cells, executor.headings, executor.passed) == ([1], [EAST], [[1]])
    assert run(executor, [free, free]) == ["RW"]
    assert (executor.ends, executor.end_headings, executor.headings) == ([1], [SOUTH], [SOUTH])


def test_robots_enter_a_cell_in_the_order_of_the_plan_once_it_is_empty() -> None:
    executor = executor_of(("....",), [1, 0], [EAST, EAST])
    executor.stage(actions_of("FF", "FF"))
    assert executor.ends == [3, 2]
    late = [[True, False]] * 3 + [[False, False]] * 8
    assert run(executor, late) == ["WWWFFFFWWWW", "WWWWWFFFFWW"]


def test_what_would_wait_in_a_circle_is_dropped() -> None:
    executor = executor_of(("..", ".."), [0, 1, 3, 2], [1, 2, 3, 0])
    executor.stage(actions_of("FF", "FR", "FR", "FR"))
    assert executor.ends == [0, 1, 3, 2]
    assert run(executor, [[False] * 4] * 2) == ["WW"] * 4
    executor.stage(actions_of("R", "R", "R", "R"))
    assert executor.end_headings == [2, 3, 0, 1]


def test_robots_that_need_the_last_tick_of_a_move_are_not_in_their_old_cells() -> None:
    executor = executor_of(("...",), [0], [EAST])
    executor.stage(actions_of("FF"))
    run(executor, [[False]])
    assert executor.passed == [[1, 2]]


def test_staged_actions_are_foreseen() -> None:
    tasks = {3: LeagueTask(3, (5, 6), 0), 4: LeagueTask(4, (7, 8), 0), 5: LeagueTask(5, (9,), 0)}
    where = np.array([6, 7, 1])
    view = View(0, where, where, tasks, np.array([3, 4, -1]), [[5, 6], [7], [9]])
    known, schedule = foreseen(view)
    assert schedule.tolist() == [-1, 4, -1]
    assert {number: task.visited for number, task in known.items()} == {4: 1, 5: 0}
    assert [task.visited for task in tasks.values()] == [0, 0, 0]


@pytest.mark.parametrize(("event", "duration"), [("bernoulli", "uniform"), ("poisson", "gaussian")])
def test_delays_are_as_frequent_and_as_long_as_a_problem_says(event: str, duration: str) -> None:
    delays = Delays(1, 4, 8, event, 0.01, duration, 0.5, 0.25)
    draw = DelayDraw(delays, 200)
    is_delayed = np.array([draw.next_tick() for _ in range(500)])
    lengths = [end - start for each in draw.intervals for start, end in each]
    assert {*lengths} == {4, 5, 6, 7, 8}
    assert np.mean(lengths) == pytest.approx(6, abs=0.15)
    assert len(lengths) / is_delayed.size == pytest.approx(0.01, rel=0.1)
    for robot, intervals in enumerate(draw.intervals):
        ticks = [tick for start, end in intervals for tick in range(start, min(end, 500))]
        assert np.flatnonzero(is_delayed[:, robot]).tolist() == ticks
    assert DelayDraw(delays, 200).next_tick().tolist() == is_delayed[0].tolist()
    assert not DelayDraw(None, 3).next_tick().any()


class Timed:
    """An entry that waits, and takes as long as is written."""

    def __init__(self, *seconds: float) -> None:
        self._seconds, self._now = iter(seconds), 0.0
        self.steps: list[int] = []

    def plan(self, view: View, steps: int) -> tuple[np.ndarray, np.ndarray]:
        self.steps.append(view.step)
        self._now += next(self._seconds, 0.5)
        return np.full(1, -1), actions_of("W" * steps)

    def clock(self) -> float:
        return self._now


def test_plans_are_made_while_robots_move_and_may_be_late() -> None:
    problem = league_of(("..",), [0], [[1]], year=2026, ticks=3)
    entry = Timed(1.25, 0.5, 2.0)
    result = play(problem, entry, 60, 1.0, entry.clock)
    assert entry.steps == [0, 3, 13, 33, 43, 53]
    assert result.late == 3 + PERIOD
    assert len(result.actual) == 60


def test_the_checker_names_ticks_against_the_rules() -> None:
    problem = league_of(("...", "###"), [0, 2], [[1]], year=2026, ticks=2)
    waits = play_ours(problem._replace(delays=None), 4)
    for texts, words in (
        (("FFFF", "WWWW"), "tick 2: robots 0 and 1 overlap"),
        (("FRWW", "WWWW"), "tick 1: robot 0 begins another action before the last ends"),
        (("RRFF", "WWWW"), "tick 2: robot 0 leaves the open cells"),
        (("WWWF", "WWWW"), "tick 3: robot 0 moves while it is delayed"),
    ):
        result = replace(waits, actual=actions_of(*texts).T, delays=[[(3, 4)], []])
        assert check_result(problem, result).error == words
    fine = replace(waits, actual=actions_of("FFRW", "WCCW").T, delays=[])
    assert ticked_cells(problem, fine).T.tolist() == [[0, 0, 1, 1, 1], [2] * 5]


@pytest.mark.parametrize(
    ("cells", "speeds", "size", "pair"),
    [
        ([(0, 0), (0, 1)], [(0, 1), (0, 1)], 1.0, None),  # one follows the other
        ([(0, 0), (0, 1)], [(0, 1), (1, 0)], 1.0, (0, 1)),  # round the corner, at once
        ([(0, 0), (0, 1)], [(0, 1), (1, 0)], 0.4, None),
        ([(0, 0), (0, 2)], [(0, 1), (0, -1)], 1.0, (0, 1)),
        ([(1, 0), (0, 1)], [(-1, 0), (0, -1)], 1.0, (1, 0)),
        ([(0, 3), (1, 0)], [(0, 1), (0, -1)], 1.0, None),  # at the ends of two rows
        ([(1, 1), (1, 1)], [(0, 0), (0, 0)], 1.0, (1, 0)),
    ],
)
def test_squares_overlap(
    cells: list[tuple[int, int]],
    speeds: list[tuple[int, int]],
    size: float,
    pair: tuple[int, int] | None,
) -> None:
    before = np.array(cells)
    assert overlap(4, before, before.astype(float), np.array(speeds, float), size) == pair


def test_paths_are_written_in_segments_that_begin_where_the_robot_is(tmp_path: Path) -> None:
    problem = league_of(("....",), [0], [[3]], year=2026, ticks=3)
    result = play_ours(problem, 1003)
    actual = result.actual.copy()
    actual[:] = LETTERS.index("W")
    actual[:3], actual[997:1001] = LETTERS.index("F"), LETTERS.index("F")
    write_result(tmp_path / "r.json", replace(result, actual=actual), problem.layout)
    [path] = json.loads((tmp_path / "r.json").read_text())["actualPaths"]
    assert path == "[(0,0,0,0,0):(F 3,W 994,F 3)][(1000,0,2,0,0):(F 1,W 2)]"
    assert np.array_equal(read_result(tmp_path / "r.json", problem.layout).actual, actual)
