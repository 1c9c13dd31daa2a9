"""Travel times between cells, which the costs of planners do not change."""

import numpy as np
import pytest

from agents.fleet.scheduler import Scheduler
from agents.fleet.travel import TravelTimes
from agents.mapf.graph import Graph
from agents.mapf.guidance import lane_costs
from warehouse_core import FleetEnv, Layout

HALL = Layout(["C" + "." * 28 + "C"])


def test_times_count_cells_and_turns_and_are_infinite_without_a_path() -> None:
    corner, far = np.array([0]), np.array([5])
    layout = Layout(["..#", "#..", "..."])
    assert TravelTimes(layout).between(corner, far).tolist() == [3]
    assert TravelTimes(layout, turn=1.0).between(corner, far).tolist() == [5]
    times = TravelTimes(layout)
    times.close(frozenset([1]))
    assert times.between(corner, far).tolist() == [np.inf]


@pytest.mark.parametrize("moves", ["compass", "turn"])
def test_a_charger_is_as_far_away_as_its_steps_whatever_lanes_cost(moves: str) -> None:
    env = FleetEnv(HALL, 1, moves=moves)
    env.reset(seed=1)
    costs = Graph(HALL, lane_costs(HALL))
    assert costs.distances(0)[14] == 5 * 14
    assert Scheduler(env, "urgent", costs).chargers.home[14] == 14


def test_chargers_behind_failed_robots_count_as_unreachable() -> None:
    layout = Layout(["C...", "####"])
    env = FleetEnv(layout, 1)
    env.reset(seed=1)
    scheduler = Scheduler(env, "urgent")
    assert scheduler.chargers.home.tolist()[:4] == [0, 1, 2, 3]
    scheduler._close(frozenset([2]))
    assert scheduler.chargers.home.tolist()[1::2] == [1, np.inf, np.inf, np.inf]
