import numpy as np
from helpers.fleets import LINE, fleet_episode

from warehouse_core import FleetEnv
from warehouse_core.records import FleetRecorder
from warehouse_core.viz.axes.heat_map import blocked_cells, blocked_heat_map


def test_blocked_moves_are_counted_where_the_robots_were() -> None:
    env = FleetEnv(LINE, 3, orders=None, starts=[(0, 2), (0, 3), (0, 8)], max_steps=9)
    recorder = FleetRecorder(env, seed=1)
    for actions in (["E", "W", "E"], ["E", "N", "W"], ["WAIT", "E", "W"], ["E", "WAIT", "E"]):
        recorder.step(actions)
    found = {name: counts.tolist() for name, counts in blocked_cells(recorder.episode).items()}
    assert found == {
        "wall": [[0, 0, 0, 1, 0, 0, 0, 0, 1]],
        "robot": [[0, 0, 2, 1, 0, 0, 0, 0, 0]],
        "person": [[0] * 9],
    }


def test_the_counts_are_those_of_the_measures() -> None:
    episode = fleet_episode()
    found, measures = blocked_cells(episode), episode.measures
    assert [int(counts.sum()) for counts in found.values()] == [
        measures.blocked_by_wall,
        measures.blocked_by_robot,
        measures.blocked_by_person,
    ]
    assert measures.blocked_by_person
    assert not np.array_equal(found["wall"] > 0, found["robot"] > 0)


def test_each_cause_has_a_heat_map() -> None:
    episode = fleet_episode()
    titles = [axes.get_title(loc="left") for axes in blocked_heat_map(episode).axes]
    count = episode.measures.blocked_by_robot
    assert f"blocked by a robot: {count} moves" in titles
    assert len([title for title in titles if title]) == 3
    lone = blocked_heat_map(fleet_episode(robots=1, people=0, orders=None, max_steps=3))
    assert "blocked by a robot: 0 moves" in [axes.get_title(loc="left") for axes in lone.axes]
