"""Planners with guidance, the choice of a planner, and former names."""

import numpy as np
import pytest
from helpers.mapf_problems import situation

from agents.errors import AgentError
from agents.fleet import guided
from agents.fleet.guided import choose
from agents.fleet.planned import PlannedFleet
from agents.mapf import guidance
from agents.registry import make_fleet_agent, make_planner
from warehouse_core import FleetEnv, Layout, OrderQueue, random_layout
from warehouse_core.records.recorder import record_fleet_episode

ROOM = Layout(["P....D", "..##..", "..##..", "D....P", "..C..."])
HALL = random_layout(12, 12, 0.1, seed=1)
"""About 90 open cells."""


@pytest.fixture(autouse=True)
def short_trials(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(guidance, "TRIAL_STEPS", 20)
    guidance.learn.cache_clear()
    yield
    guidance.learn.cache_clear()


@pytest.mark.parametrize("name", ["pibt", "windowed", "circulation"])
def test_costs_are_learned_once_for_all_seeds_and_guide_robots(name: str, monkeypatch) -> None:
    calls, learned = [], guidance.learned_costs
    monkeypatch.setattr(
        guidance, "learned_costs", lambda *a, **k: calls.append(a) or learned(*a, **k)
    )
    actions = []
    for seed in (1, 2, 1):
        agent = make_fleet_agent(f"{name}:guidance=learned", None, seed, ROOM, 4)
        env = FleetEnv(ROOM, 4, orders=OrderQueue(8), max_steps=30, dispatch=False)
        episode = record_fleet_episode(env, agent, seed=seed)
        assert episode.measures.delivered > 1
        assert episode.measures.blocked_by_robot == 0
        actions.append(episode.actions)
    assert calls == [(ROOM, 4)]
    assert np.array_equal(actions[0], actions[2])
    make_fleet_agent(f"{name}:guidance=learned", None, 1, ROOM, 3)
    assert calls[1] == (ROOM, 3)


def test_guided_paths_avoid_chargers_and_windows_follow_guidance_less() -> None:
    full, half, lanes, none = (
        make_planner(f"{name}:guidance={guidance}", 0, ROOM, 3).graph.costs
        for name, guidance in (
            ("pibt", "learned"), ("windowed", "learned"), ("pibt", "lanes"), ("pibt", "none"),
        )
    )  # fmt: skip
    learned = guidance.learn(ROOM, 3).costs
    for costs in (full, lanes, none):
        assert {(20, 2), (25, 1), (27, 3)} <= set(map(tuple, np.argwhere(costs > 20).tolist()))
    is_plain = none == 1
    assert np.array_equal(full[is_plain], learned[is_plain])
    assert np.allclose(half[is_plain] - 1, (learned[is_plain] - 1) / 2, atol=0.06)
    assert sorted(set(lanes[is_plain].tolist())) == [1, 5]
    with pytest.raises(ValueError, match="read-only"):
        learned[0] = 1
    with pytest.raises(AgentError, match=r"guidance is 'sun'; allowed: none, lanes, learned"):
        make_planner("pibt:guidance=sun", 0, ROOM, 3)


@pytest.mark.parametrize("name", ["pibt", "windowed", "circulation"])
def test_a_floor_of_one_cell_needs_no_trials(name: str) -> None:
    planner = make_planner(f"{name}:guidance=learned", 0, Layout(["."]), 1)
    assert planner.next_cells(situation([0])).tolist() == [0]


def test_auto_chooses_by_robots_per_cell_headings_time_and_trials(monkeypatch) -> None:
    gain = 2.0
    monkeypatch.setattr(
        guided, "learn", lambda layout, robots: guidance.learn(layout, robots)._replace(gain=gain)
    )
    assert choose(HALL, 8) == ("windowed", "8 robots, 0.09 per open cell")
    assert choose(HALL, 40).name == "windowed:guidance=learned"
    assert choose(HALL, 40).reason.endswith("reach 2.00 times as many goals in trials")
    assert choose(HALL, 60).name == "circulation:guidance=learned"
    assert choose(HALL, 60, "turn").name == "windowed:guidance=learned"
    assert choose(HALL, 80, "turn").name == "circulation:guidance=learned"
    assert choose(HALL, 40, seconds=0.001).name == "circulation:guidance=learned"
    gain = 1.1
    assert choose(HALL, 40).name == "windowed"


def test_auto_is_what_it_has_chosen() -> None:
    agent = make_fleet_agent("auto", None, 1, ROOM, 4)
    assert isinstance(agent, PlannedFleet)
    assert agent.planner.choice == ("windowed", "4 robots, 0.15 per open cell")
    assert make_planner("auto:seconds=0.5", 1, ROOM, 4).seconds == 0.5
    crowded = make_planner("auto", 1, HALL, 60)
    assert crowded.choice.name.startswith("circulation")
