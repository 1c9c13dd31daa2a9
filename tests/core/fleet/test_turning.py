"""Robots with headings, which drive forward and turn on the spot."""

import math
from typing import Any

import numpy as np
import pytest
from helpers.fleets import SHELVES

from warehouse_core import FleetEnv, GridMotion, Layout
from warehouse_core.fleet import FleetBatch
from warehouse_core.motion.base import BaseMotion
from warehouse_core.task import rules
from warehouse_core.world.moves import TURN_ACTIONS

FORWARD, RIGHT, LEFT, WAIT, PICK, DROP = range(6)


def begun(*args: Any, **settings: Any) -> FleetEnv:
    fleet = FleetEnv(*args, moves="turn", **settings)
    fleet.reset(seed=1)
    return fleet


def test_turns_cost_what_moves_cost_and_do_not_count_as_distance_or_waits() -> None:
    fleet = begun(["P.D"], 2, starts=[(0, 0), (0, 2)])
    rewards = [fleet.step([action, WAIT])[1][0] for action in (PICK, RIGHT, FORWARD, LEFT, FORWARD)]
    assert rewards == [
        rules.STEP_REWARD + rules.PICK_REWARD,
        rules.STEP_REWARD,
        rules.STEP_REWARD + rules.BLOCKED_REWARD,
        rules.STEP_REWARD,
        rules.STEP_REWARD,
    ]
    measures = fleet.measures
    assert (measures.distance, measures.waits, measures.blocked_by_wall) == (1, 5, 1)


def test_a_turn_on_a_charger_does_not_charge() -> None:
    fleet = begun(["C.."], 1, starts=[(0, 0)], battery=50)
    for action, units in ((LEFT, 49), (RIGHT, 48), (WAIT, 50)):
        fleet.step([action])
        assert fleet.battery == [units]


def test_words_and_indices_are_those_of_the_six_actions() -> None:
    fleet = begun(robots=3)
    given = fleet.action_indices(["forward", "Left", "E"])
    assert given.tolist() == [FORWARD, LEFT, 7]
    assert fleet.action_indices(np.array([0, 5, 6])).tolist() == [0, 5, 7]
    assert fleet.action_indices({0: 1, 1: "DROP", 2: -1}).tolist() == [RIGHT, DROP, 7]
    with pytest.raises(TypeError, match=r"allowed: one of FORWARD, RIGHT, .*, DROP or its index 0"):
        fleet.step([1.5, 1, 1])  # type: ignore[list-item]
    with pytest.raises(ValueError, match=r"^moves is 'diagonal'; allowed: compass, turn"):
        FleetEnv(moves="diagonal")


def test_a_robot_that_has_ended_does_not_turn_and_a_reset_turns_all_to_the_east() -> None:
    fleet = begun(["....."], 2, starts=[(0, 0), (0, 4)], battery=2)
    for action in (RIGHT, LEFT):
        fleet.step({0: action, 1: RIGHT})
    assert (fleet.ended, fleet.headings) == ([True, True], [1, 3])
    fleet.reset(seed=1)
    assert fleet.headings == [1, 1]
    fleet = begun(["PD..."], 2, starts=[(0, 0), (0, 4)])
    for action in (PICK, FORWARD, DROP, LEFT):
        fleet.step([action, LEFT])
    assert (fleet.ended, fleet.headings) == ([True, False], [1, 1])


def test_robots_observe_their_headings() -> None:
    fleet = begun(robots=2)
    arrays = fleet.step([RIGHT, LEFT])[0]
    assert arrays["heading"].tolist() == fleet.headings == [2, 0]
    assert fleet.observe(0)["heading"] == "S"
    assert [each["heading"] for each in fleet.observations()] == ["S", "N"]
    other = FleetEnv(robots=2)
    assert "heading" not in other.reset(seed=1)[0]
    assert "heading" not in other.observe(0)
    assert other.headings == []


def test_actions_of_a_batch_are_those_of_robots_with_headings() -> None:
    batch = FleetBatch(3, SHELVES, 4, moves="turn")
    batch.reset(seed=5)
    with pytest.raises(ValueError, match=r"^the action of row 0 is 6; allowed: 0\.\.5"):
        batch.step([len(TURN_ACTIONS)] * 12)


def test_the_grid_turns_robots_by_the_smaller_angle() -> None:
    fleet = begun(["..", ".."], 2, starts=[(0, 0), (1, 1)])
    turned = []
    for _ in range(4):
        fleet.step([LEFT, RIGHT])
        turned.append([outcome.path[:, 3].tolist() for outcome in fleet.last_motion])
    quarter = math.pi / 2
    for one, other in turned:
        assert one[1] - one[0] == -quarter
        assert other[1] - other[0] == quarter
    ends = [[round(one[1] / quarter) % 4 for one in pair] for pair in turned]
    assert ends == [[3, 1], [2, 2], [1, 3], [0, 0]]
    fleet.step([FORWARD, WAIT])
    moved, waited = fleet.last_motion
    assert (moved.cell, moved.path[:, 3].tolist(), waited.path[:, 3].tolist()) == (
        (0, 1), [0.0, 0.0], [0.0, 0.0]
    )  # fmt: skip


def test_a_motion_that_cannot_turn_waits_instead() -> None:
    class Plain(GridMotion):
        face = BaseMotion.face

        def advance(self, displacements: Any, loaded: Any) -> Any:
            return super().advance(displacements, loaded)

    fleet = begun(["...", "..."], 2, backend=Plain, starts=[(0, 0), (0, 2)])
    fleet.step([RIGHT, LEFT])
    fleet.step([FORWARD, WAIT])
    assert (fleet.cells, fleet.headings) == ([(1, 0), (0, 2)], [2, 0])


def test_directions_are_checked_before_anything_changes() -> None:
    motion = GridMotion()
    with pytest.raises(RuntimeError, match=r"^face\(\) needs a reset\(\)"):
        motion.face([(0, 1)])
    motion.reset(Layout(["..", ".."]), [(0, 0), (1, 1)], None)
    with pytest.raises(ValueError, match=r"^1 directions for 2 robots; each robot needs one"):
        motion.face([(0, 1)])
    with pytest.raises(ValueError, match=r"^direction \(1, 1\) of robot 1; allowed: \[\(-1, 0\)"):
        motion.face([(0, 1), (1, 1)])
    outcomes = motion.advance([(0, 0), (0, 0)], [False, False])
    assert [outcome.path[1, 3] for outcome in outcomes] == [0.0, 0.0]
