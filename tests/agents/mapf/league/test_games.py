"""Games of the League, their results in files, and the checker."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.league import league_of

from agents.errors import PlanError
from agents.mapf.epibt import EPIBT
from agents.mapf.graph import Graph
from agents.mapf.league import scheduler
from agents.mapf.league.checker import cells_of, check_result
from agents.mapf.league.entry import PlannedEntry, View, first_robots, plan_steps
from agents.mapf.league.result import Result, read_result, write_result
from agents.mapf.league.rules import LETTERS
from agents.mapf.league.scheduler import Scheduler
from agents.mapf.league.simulator import play
from agents.mapf.planner import Situation
from warehouse_core import Layout, random_layout
from warehouse_core.world.robot_runners import League

ROW = (".....",)
OPEN = random_layout(10, 10, 0.15, seed=2).with_tiles([], [], [])
YEARS: dict[int, dict[str, Any]] = {2023: {"strategy": "roundrobin"}, 2024: {}}


def crowd(year: int, robots: int = 12) -> League:
    """Return a problem of robots on a floor with walls."""
    cells = np.random.default_rng(3).permutation(OPEN.open_cells).tolist()
    length = 1 if year == 2023 else 3
    tasks = [cells[start : start + length] for start in range(len(cells) - length)]
    revealed = robots if year == 2023 else 18
    return league_of(OPEN.rows, cells[:robots], tasks, revealed=revealed, year=year, **YEARS[year])


def play_ours(problem: League, steps: int) -> Result:
    graph = Graph(problem.layout)
    tasks = None if problem.strategy else Scheduler(graph, problem.revealed)
    return play(problem, PlannedEntry(graph, EPIBT(graph), tasks), steps, seconds=1000)


class Script:
    """An entry that says what is written, and takes as long as is written."""

    def __init__(
        self, texts: list[str], seconds: tuple[float, ...] = (), schedule: int = 0
    ) -> None:
        self._texts, self._schedule = iter(texts), schedule
        self.views: list[View] = []
        self._now = 0.0
        self._seconds = iter(seconds)

    def plan(self, view: View, steps: int) -> tuple[np.ndarray, np.ndarray]:
        self.views.append(view)
        self._now += next(self._seconds, 0.0)
        actions = [[LETTERS.index(letter)] for letter in next(self._texts, "W" * len(view.cells))]
        return np.full(len(view.cells), self._schedule), np.array(actions)

    def clock(self) -> float:
        return self._now


def letters_of(actions: np.ndarray) -> list[str]:
    return ["".join(LETTERS[each] for each in column) for column in actions.T]


@pytest.mark.parametrize("year", YEARS)
def test_games_are_accepted_and_written_and_read_again(year: int, tmp_path: Path) -> None:
    problem = crowd(year)
    result = play_ours(problem, 60)
    assert result.finished > 12
    assert check_result(problem, result) == ("", result.finished)
    write_result(tmp_path / "r.json", result, problem.layout)
    read = read_result(tmp_path / "r.json", problem.layout)
    assert check_result(problem, read).error == ""
    for key, value in vars(replace(result, year=2024)).items():
        assert np.array_equal(getattr(read, key), value) or getattr(read, key) == value, key


def test_a_late_plan_makes_steps_of_waiting() -> None:
    problem = league_of(ROW, [0], [[1, 3]])
    entry = Script(["F"] * 9, (2.5, 0.75, 1.0, 9.0))
    result = play(problem, entry, 9, 1.0, entry.clock)
    assert letters_of(result.planned) == ["TTFFTFTTT"]
    assert letters_of(result.actual) == ["WWFFWFWWW"]
    assert [view.step for view in entry.views] == [0, 3, 4, 6]
    assert (result.late, result.seconds, result.finished) == (6, [2.5, 0.75, 1.0, 9.0], 1)
    assert check_result(problem, result) == ("", 1)


def test_robots_of_2023_do_errands_while_they_wait_for_a_late_plan() -> None:
    problem = league_of(ROW, [0], [[0]], strategy="roundrobin", year=2023)
    entry = Script([], (3.0,))
    assert play(problem, entry, 4, 1.0, entry.clock).finished == 4
    assert check_result(problem, play(problem, Script([]), 4, 1.0)) == ("", 4)


def test_all_robots_wait_instead_of_an_action_with_an_error() -> None:
    problem = league_of(ROW, [0, 1], [[4]])
    result = play(problem, Script(["FW", "FF", "W"], schedule=-1), 3, 1000)
    assert letters_of(result.actual) == ["WFW", "WFW"]
    assert letters_of(result.planned)[0][:2] == "FF"
    assert result.errors == [
        (1, 0, 1, "vertex conflict"),
        (-1, -1, 3, "incorrect vector size"),
    ]


def test_on_full_floors_robots_with_the_least_left_to_do_go_first(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for name, value in (("FULL", 0.8), ("BUSY_BY_CELL", 0.0), ("BUSY_BY_ROBOT", 0.5)):
        monkeypatch.setattr(scheduler, name, value)
    graph = Graph(Layout(["....."] * 2))
    # Seven, none, three, three, one, six, four, two and seven steps are left.
    errands = [[4, 1], [], [5], [1, 2], [9], [9, 7], [6, 2, 3, 4], [9], [4, 0, 1]]
    cells = np.arange(9)
    assert first_robots(graph, cells, errands).tolist() == [4, 7, 2, 3]
    assert first_robots(graph, cells[:8], errands[:8]).tolist() == []
    noted = list[Any]()

    class Noting(EPIBT):
        def next_places(self, situation: Situation, headings: Any) -> Any:
            noted.append(situation.urgent.tolist())
            return super().next_places(situation, headings)

    plan_steps(graph, Noting(graph), cells, np.ones(9, int), errands, 2)
    assert noted == [[4, 7, 2, 3]] * 2


def test_a_problem_that_cannot_be_finished_is_refused() -> None:
    for problem, words in (
        (league_of(("..#.",), [0], [[1], [1, 3]]), r"task 1 has \(0, 3\), to which no way leads"),
        (league_of(("..#.",), [0, 3], [[1]]), r"robot 1 has \(0, 3\), to which no way leads"),
    ):
        with pytest.raises(PlanError, match=words):
            play(problem, Script([]), 2, 1.0)


@pytest.fixture
def game() -> tuple[League, Result]:
    problem = crowd(2024)
    return problem, play_ours(problem, 40)


def actions_with(result: Result, step: int, robot: int, letter: str) -> np.ndarray:
    actions = result.actual.copy()
    actions[step, robot] = LETTERS.index(letter)
    return actions


def test_the_checker_names_what_is_wrong_in_a_result(game: tuple[League, Result]) -> None:
    problem, result = game
    number, (step, cells) = 20, result.tasks[20]
    begun = next(each for each in result.errands if each.visited == 1 and each.step > 5)
    other = [[*each] for each in result.schedule]
    other[begun.robot] = [*other[begun.robot], (begun.step + 1, -1)]
    late = next(i for i, each in enumerate(result.tasks) if each[0] > 3)
    early = [[(1, late)], *([] for _ in result.schedule[1:])]
    twice = [[(1, 0)], [(1, 0)], *([] for _ in result.schedule[2:])]
    for change, words in (
        ({"starts": result.starts[::-1]}, "robots do not start where the problem says"),
        ({"finished": 0}, f"{result.finished} tasks are finished; the result says 0"),
        ({"tasks": [*result.tasks[:number], (step, cells[::-1])]}, "task 20 is not that of the pr"),
        ({"tasks": [*result.tasks, (30, result.tasks[0][1])]}, " is not that of the problem"),
        ({"tasks": result.tasks[:-1]}, "tasks known; the problem has 18"),
        ({"errands": result.errands[1:]}, "the errands are others"),
        ({"schedule": other}, f"leaves task {begun.task}, once begun"),
        ({"schedule": early}, f"step 1: task {late} is not known yet"),
        ({"schedule": twice}, "step 1: robot 1 cannot have task 0"),
    ):
        assert words in check_result(problem, replace(result, **change)).error
    assert check_result(problem, replace(result, schedule=[])) == ("", None)


def test_the_checker_names_moves_against_the_rules() -> None:
    rows, moves = ("..", ".."), {"F": "leaves the open cells", "CF": "leaves the open cells"}
    for text, words in moves.items():
        problem = league_of(rows, [1], [[0]])
        result = play(problem, Script(["W"] * len(text)), len(text), 1000)
        for step, letter in enumerate(text):
            result = replace(result, actual=actions_with(result, step, 0, letter))
        assert words in check_result(problem, result).error
    problem = league_of(("...",), [0, 1], [[0]])
    waiting = play(problem, Script(["WW"] * 3, schedule=-1), 3, 1000)
    shared = replace(waiting, actual=actions_with(waiting, 0, 0, "F"))
    assert check_result(problem, shared).error == "step 1: two robots share a cell"
    for step, letters in enumerate(("WC", "WC", "FF")):
        for robot, letter in enumerate(letters):
            waiting = replace(waiting, actual=actions_with(waiting, step, robot, letter))
    assert check_result(problem, waiting).error == "step 3: two robots change places"


def test_a_result_of_2023_is_read(tmp_path: Path) -> None:
    problem = league_of(ROW, [0], [[1], [0]], strategy="roundrobin", year=2023)
    given = {
        "actionModel": "MAPF_T", "AllValid": "No", "teamSize": 1, "start": [[0, 0, "E"]],
        "numTaskFinished": 1, "sumOfCost": 3, "makespan": 3, "actualPaths": ["W,F,C"],
        "plannerPaths": ["T,F,C"], "plannerTimes": [1.5, 0.5],
        "errors": [[-1, -1, 1, "incorrect vector size"]],
        "events": [[[0, 0, "assigned"], [0, 2, "finished"], [1, 2, "assigned"]]],
        "tasks": [[0, 0, 1], [1, 0, 0]],
    }  # fmt: skip
    path = tmp_path / "theirs.json"
    path.write_text(json.dumps(given))
    result = read_result(path, problem.layout)
    assert (result.year, result.tasks, result.schedule) == (
        2023,
        [(0, (1,)), (2, (0,))],
        [[(0, 0), (2, 1)]],
    )
    assert letters_of(result.planned) == ["TFC"]
    assert result.errands == [(2, 0, 0, 1)]
    assert check_result(problem, result) == ("", 1)
    assert cells_of(problem, result).tolist() == [[0], [0], [1], [1]]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"actionModel": "MAPF"}, "actionModel is 'MAPF'; it must be MAPF_T"),
        ({"start": [[0, 0, "N"]]}, "robots start heading E"),
        ({"start": [[0, 9, "E"]]}, "a place is not on the map"),
        ({"actualPaths": ["F,X"]}, "an action of a path is none of F, R, C, W, T"),
        ({"actualPaths": ["F,F", "F"]}, "no result of the League: "),
        ({"actualPaths": 3}, "no result of the League: "),
        ({"numTaskFinished": None}, "no result of the League: "),
        ({"tasks": [[0, 0, [0]]]}, "no result of the League: "),
    ],
)
def test_a_file_that_is_no_result_is_refused(
    change: dict[str, Any], words: str, tmp_path: Path
) -> None:
    problem, path = league_of(ROW, [0], [[1]]), tmp_path / "r.json"
    write_result(path, play(problem, Script(["F"]), 1, 1000), problem.layout)
    given = json.loads(path.read_text())
    path.write_text(json.dumps(given | change))
    with pytest.raises(PlanError, match=words):
        read_result(path, problem.layout)
    del given["start"]
    path.write_text(json.dumps(given))
    with pytest.raises(PlanError, match="'start' is missing"):
        read_result(path, problem.layout)
