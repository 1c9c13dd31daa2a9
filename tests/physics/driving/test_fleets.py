"""Fleets whose robots drive through: rules, records, replays, and commands that refuse them."""

import pytest
from helpers.fleets import SHELVES, fleet_episode

from agents.fleet.planned import PlannedFleet
from agents.mapf.graph import Graph
from agents.mapf.pibt import PIBT
from warehouse_core import FleetEnv, FleetEpisode, WarehouseEnv, replay_fleet_episode
from warehouse_core.errors import BackendError
from warehouse_core.fleet import Battery
from warehouse_physics import DrivingMotion


@pytest.fixture(scope="module")
def episode() -> FleetEpisode:
    agent = PlannedFleet(PIBT(Graph(SHELVES)), seconds=60.0)
    return fleet_episode(agent, people=0, backend="driving", max_steps=50)


def test_a_record_is_the_same_after_a_file_and_after_a_replay(episode, tmp_path) -> None:
    episode.save(tmp_path / "fleet.npz")
    loaded = FleetEpisode.load(tmp_path / "fleet.npz")
    assert loaded == episode
    assert loaded.backend == "driving"
    assert replay_fleet_episode(loaded) == episode


def test_a_robot_picks_and_drops_only_at_rest() -> None:
    env = FleetEnv(["P..D"], 1, starts=[(0, 2)], backend=DrivingMotion(period=0.25))
    env.reset(seed=0)
    was_driving = False
    for side, action, loads in (("W", "PICK", True), ("E", "DROP", False)):
        for _ in range(40):
            at = env.routes.ends[0]
            goal = (0, 0) if loads else (0, 3)
            env.step([action if at == goal else side])
            in_goal, rests = env.cells[0] == goal, env.routes.at_rest[0]
            was_driving |= in_goal and not rests
            assert (env.loaded[0] == loads) == (in_goal and rests)
            if env.loaded[0] == loads:
                break
    assert was_driving
    assert env.measures.delivered == 1


def test_a_step_counts_as_a_wait_only_if_the_robot_is_at_rest_at_its_end() -> None:
    env = FleetEnv(["P...D"], 1, starts=[(0, 0)], backend=DrivingMotion(period=0.25))
    env.reset(seed=0)
    env.step(["PICK"])
    rests = 0
    for step in range(36):
        drives = step >= 6 and env.routes.has_room[0] and env.routes.ends[0] != (0, 4)
        env.step(["E" if drives else "WAIT"])
        rests += not drives and env.routes.at_rest[0]
    assert env.cells == [(0, 4)]
    assert (env.measures.distance, env.measures.waits) == (4, rests)
    assert 5 <= rests <= 15  # of 36 steps: it picks in 3 and drives in about 20


def test_a_robot_that_drives_over_a_charger_is_not_charged() -> None:
    motion = DrivingMotion(period=0.25)
    env = FleetEnv(
        ["..C.."], 1, starts=[(0, 0)], battery=Battery(100, charge=30), backend=motion, max_steps=90
    )
    env.reset(seed=0)
    units, over = [], 0
    for _ in range(30):
        env.step(["E" if env.routes.ends[0] != (0, 4) else "WAIT"])
        units.append(env.battery[0])
        over += env.cells[0] == (0, 2)
    assert over >= 2
    assert units == sorted(units, reverse=True)
    for _ in range(30):
        env.step(["W" if env.routes.ends[0] != (0, 2) else "WAIT"])
    assert env.battery == [100]


def test_the_chapters_environment_cannot_use_the_backend() -> None:
    with pytest.raises(BackendError, match="'driving' drives through the cells of a plan"):
        WarehouseEnv(backend="driving")
