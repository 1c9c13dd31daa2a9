"""A game of the League on bodies: times, stops, energy, and robots that wait for others."""

import numpy as np
import pytest

from agents.lab.commands.gap import game
from agents.lab.commands.gap.game import GameScore, game_of, play_in
from agents.lab.commands.gap.worlds import ALONE, DISTURBED, DRIVING, PLAN, STOPPING, Shocks
from agents.mapf.execution import drive_through
from agents.mapf.league.result import Result
from agents.mapf.league.rules import LETTERS
from agents.mapf.league.tasks import Errand
from warehouse_core import Layout
from warehouse_physics import RobotSpec

FLOOR = Layout(["......"] * 3)
SHOCKS = Shocks(0.0, 0.0)
WHEELS = RobotSpec(drive="differential")


def score(
    world: str,
    actions: dict[int, str],
    done: list[int],
    shocks: Shocks = SHOCKS,
    most: int = 100,
) -> GameScore:
    """Return what robots reach with a task each.

    Args:
        world: world to play in.
        actions: letters of the steps of a robot, by its first cell.
        done: step in which each has finished its task.
        shocks: shocks of the world.
        most: steps after which the game ends.
    """
    starts, steps = np.array([*actions]), max(map(len, actions.values()))
    plan = np.array([[*map(LETTERS.index, each.ljust(steps, "W"))] for each in actions.values()]).T
    tasks = [(0, (0, 0))] * len(starts)
    errands = [Errand(step, robot, robot, 2) for robot, step in enumerate(done)]
    errands += [errand._replace(visited=1) for errand in errands]
    result = Result(
        2024, 1, starts, plan, plan, len(done), 0, [], [0.1] * steps, tasks, sorted(errands)
    )
    return play_in(world, 0, game=game_of(FLOOR, result, most), shocks=shocks)


@pytest.mark.parametrize(
    ("world", "letters", "seconds"),
    [
        (PLAN, "FFFF", 4), (DRIVING, "FFFF", 5), (ALONE, "FFFF", 5), (STOPPING, "FFFF", 8),
        (PLAN, "FRF", 3), (DRIVING, "FRF", 6), (STOPPING, "FRF", 6), (DRIVING, "FCRF", 5),
    ],
)  # fmt: skip
def test_a_task_is_finished_once_its_robot_is_in_the_middle_of_the_last_cell(
    world: str, letters: str, seconds: int
) -> None:
    done = len(letters)
    for steps, finished in ((seconds, 1), (seconds - 1, 0)):
        padded = letters.ljust(steps, "W")[:steps]
        ends = [done] if done <= steps else []
        assert score(world, {0: padded}, ends).finished == finished


def test_a_task_that_ends_in_a_cell_where_its_robot_waits_is_finished_there() -> None:
    for world in (PLAN, DRIVING, STOPPING):
        assert score(world, {0: "WWF"}, [2]).finished == 1


def test_of_the_first_steps_of_a_game_only_those_tasks_count_that_they_finish() -> None:
    letters = {0: "FFFF", 6: "FWWW"}
    assert [score(PLAN, letters, [4, 1], most=steps).finished for steps in (4, 3)] == [2, 1]


def test_in_joint_steps_all_wait_for_the_last() -> None:
    letters = {0: "FFFFWWW", 6: "WWWWWWW"}
    assert score(STOPPING, letters, [4, 4]).finished == 0


def test_stops_are_counted_where_bodies_come_to_rest() -> None:
    letters = {0: "FFRF".ljust(12, "W")}
    stops = {world: score(world, letters, [4]).stops for world in (PLAN, STOPPING, DRIVING)}
    assert stops == {PLAN: 2, STOPPING: 3, DRIVING: 2}


def test_energy_is_that_of_the_whole_game() -> None:
    found = score(DRIVING, {0: "FFFF".ljust(20, "W")}, [4])
    driven = drive_through(FLOOR, np.arange(5)[:, None], WHEELS)
    idle = WHEELS.idle_power * (20 - driven.seconds)
    assert found.joules == pytest.approx(driven.joules + idle, rel=0.01)
    waits = score(STOPPING, {0: "W" * 20}, [])
    assert waits.joules == pytest.approx(20 * WHEELS.idle_power)
    assert score(PLAN, {0: "W" * 20}, []).joules == pytest.approx(waits.joules)


def test_robots_wait_for_those_that_turn_before_them_unless_each_is_alone() -> None:
    # The second robot follows the first through the cell in which that turns.
    letters = {1: "FRFWWW", 0: "WFFFWW"}
    alone, driven = (score(world, letters, [3, 4]) for world in (ALONE, DRIVING))
    assert (alone.finished, driven.finished) == (2, 1)
    assert (alone.hits, driven.hits) == (0, 0)


def test_robots_on_their_own_floors_do_the_same_in_one_run_and_in_several(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    letters, done = {0: "FFFFWWWW", 6: "FRWWWWWW", 17: "WWRRFFWW"}, [4, 1, 6]
    whole = score(ALONE, letters, done)
    monkeypatch.setattr(game, "MAX_CELLS", 2 * 4 * 6)
    parts = score(ALONE, letters, done)
    assert parts._replace(joules=0) == whole._replace(joules=0)
    assert parts.joules == pytest.approx(whole.joules)
    assert whole.finished == 2


def test_a_robot_that_has_died_does_what_one_does_that_stands_to_the_end() -> None:
    letters = {0: "F" * 5 + "W" * 5}
    dead, stands = (score(DISTURBED, letters, [5], Shocks(0.0, stop)) for stop in (np.inf, 1e3))
    assert dead == stands
    assert dead.finished == 0
    assert score(DISTURBED, letters, [5], Shocks(0.0, 1.0)).finished == 1
