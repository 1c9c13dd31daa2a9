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
from warehouse_core.world.tiles import Cell

FORWARD, RIGHT, LEFT, WAIT, PICK, DROP = range(6)
AHEAD = ((-1, 0), (0, 1), (1, 0), (0, -1))
"""Displacement of FORWARD for each heading, clockwise from north."""


def begun(*args: Any, **settings: Any) -> FleetEnv:
    fleet = FleetEnv(*args, moves="turn", **settings)
    fleet.reset(seed=1)
    return fleet


class Model:
    """The simplest implementation of the rules of robots with headings."""

    def __init__(self, layout: Layout, cells: list[Cell]) -> None:
        self.layout, self.cells, self.headings = layout, cells, [1] * len(cells)

    def step(self, actions: list[int]) -> list[bool]:
        """Carry out actions, and return flags of the blocked robots."""
        goals, cells = list(self.cells), self.cells
        for robot, action in enumerate(actions):
            row, col = cells[robot]
            down, right = AHEAD[self.headings[robot]]
            if action == FORWARD:
                goals[robot] = row + down, col + right
            elif action in (RIGHT, LEFT):
                by = 1 if action == RIGHT else -1
                self.headings[robot] = (self.headings[robot] + by) % 4
        tries = [goal != cell for goal, cell in zip(goals, cells, strict=True)]
        walled = [not self.layout.is_open(goal) for goal in goals]
        stays = list(walled)
        for one, goal in enumerate(goals):
            for other in range(len(cells)):
                if one != other and tries[one] and tries[other] and not walled[other]:
                    stays[one] |= goals[other] == goal
                    stays[one] |= goals[other] == cells[one] and goal == cells[other]
        while True:
            at_rest = {cells[i] for i in range(len(cells)) if stays[i] or not tries[i]}
            caught = [i for i, goal in enumerate(goals) if tries[i] and not stays[i]]
            caught = [i for i in caught if goals[i] in at_rest]
            if not caught:
                break
            for robot in caught:
                stays[robot] = True
        self.cells = [cell if stay else goal
                      for cell, goal, stay in zip(cells, goals, stays, strict=True)]  # fmt: skip
        return [each and stay for each, stay in zip(tries, stays, strict=True)]


@pytest.mark.parametrize("robots", [3, 14, 60])
def test_random_steps_are_those_of_the_model(robots: int) -> None:
    stream, starts = np.random.default_rng(robots), np.random.default_rng(1)
    layout = Layout(["." * 10] * 8) if robots > 40 else SHELVES
    cells = [layout.open_cell(int(n)) for n in starts.permutation(len(layout.open_cells))[:robots]]
    fleet, model = (
        begun(layout, robots, starts=cells, max_steps=300, battery=300),
        Model(layout, cells),
    )
    assert fleet.headings == model.headings
    met = 0
    for _ in range(250):
        # Half of the moves are forward, so that robots meet.
        actions = np.where(stream.random(robots) < 0.5, FORWARD, stream.integers(4, size=robots))
        free = fleet.step(actions)[4]["motion"]["stopped_by"]
        blocked = model.step(actions.tolist())
        assert (fleet.cells, fleet.headings) == (model.cells, model.headings)
        assert (free != -1).tolist() == blocked
        met += int((free >= 0).sum())
    assert met > 20


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


def test_fleets_of_a_batch_are_as_each_alone() -> None:
    settings = {"orders": 0.2, "people": 1, "moves": "turn", "max_steps": 60}
    batch = FleetBatch(3, SHELVES, 4, autoreset_mode="Disabled", **settings)
    observed, _ = batch.reset(seed=5)
    alone = [FleetEnv(SHELVES, 4, **settings) for _ in range(3)]  # type: ignore[arg-type]
    for number, fleet in enumerate(alone):
        fleet.reset(seed=5 + number)
    for chosen in np.random.default_rng(3).integers(6, size=(59, 12)):
        observed, rewards, *_, info = batch.step(chosen)
        steps = [fleet.step(chosen[4 * b : 4 * b + 4]) for b, fleet in enumerate(alone)]
        for key in ("heading", "robot_pos"):
            parts = [step[0][key] for step in steps]  # type: ignore[literal-required]
            assert np.array_equal(observed[key], np.concatenate(parts))  # type: ignore[literal-required]
        assert np.array_equal(rewards, np.concatenate([step[1] for step in steps]))
        masks = [step[4]["action_mask"] for step in steps]
        assert np.array_equal(info["action_mask"], np.concatenate(masks))
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
