"""Planners with learned costs, by name."""

import numpy as np
import pytest
from helpers.mapf_problems import situation

from agents.fleet import guided
from agents.registry import make_fleet_agent, make_planner
from warehouse_core import FleetEnv, Layout, OrderQueue
from warehouse_core.records.recorder import record_fleet_episode

ROOM = Layout(["P....D", "..##..", "..##..", "D....P", "..C..."])
LITTLE = "trials=2"


@pytest.mark.parametrize("name", ["pibt-learned", "windowed-learned"])
def test_costs_are_learned_once_for_all_seeds_and_guide_robots(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls, learn = [], guided.learned_costs
    monkeypatch.setattr(guided, "learned_costs", lambda *a, **k: calls.append(a) or learn(*a, **k))
    guided.learned_fleet_costs.cache_clear()
    actions = []
    for seed in (1, 2, 1):
        agent = make_fleet_agent(f"{name}:{LITTLE}", None, seed, ROOM, 4)
        env = FleetEnv(ROOM, 4, orders=OrderQueue(8), max_steps=60, dispatch=False)
        episode = record_fleet_episode(env, agent, seed=seed)
        assert episode.measures.delivered > 3
        assert episode.measures.blocked_by_robot == 0
        actions.append(episode.actions)
    assert len(calls) == 1
    assert np.array_equal(actions[0], actions[2])
    assert not np.array_equal(actions[0], actions[1])
    make_fleet_agent(f"{name}:{LITTLE},robots=3", None, 1, ROOM, 4)
    assert calls[1][1] == 3


def test_paths_with_learned_costs_avoid_chargers() -> None:
    graph = guided.on_learned(ROOM, 3, trials=1)
    learned = guided.learned_fleet_costs(ROOM, 3, 1, guided.TRIAL_SEED)
    assert graph.costs is not None
    dearer = {tuple(each) for each in np.argwhere(graph.costs - learned > 5).tolist()}
    assert {(20, 2), (25, 1), (27, 3)} <= dearer


@pytest.mark.parametrize("name", ["windowed-learned", "windowed-directed", "circulation-directed"])
def test_a_floor_of_one_cell_needs_no_trials(name: str) -> None:
    planner = make_planner(f"{name}:trials=999,robots=50", 0, Layout(["."]), 1)
    assert planner.next_cells(situation([0])).tolist() == [0]
