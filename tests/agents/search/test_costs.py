"""Costs of actions as measured with a backend."""

from collections.abc import Sequence

import pytest

from agents.search.algorithms import astar_search
from agents.search.costs import JOULES, ONE_EACH, SECONDS, STEPS, ActionCosts, action_costs
from agents.search.heuristics import manhattan_delivery
from agents.search.problems import DeliveryProblem
from warehouse_core import Cell, Layout, Outcome, WarehouseEnv
from warehouse_core.errors import BackendError
from warehouse_core.motion.backends import Backend
from warehouse_core.motion.grid import GridMotion, nominal_joules

LANE = Layout(["##########", "#...P...D#", "##########"])


def test_steps_cost_one_on_any_backend() -> None:
    assert action_costs() == action_costs(STEPS, "grid") == ONE_EACH == (1, 1, 1, 1)
    assert action_costs(STEPS, "no such backend") == ONE_EACH, "it is not used"


@pytest.mark.parametrize(("backend", "size"), [("grid", 1.0), (GridMotion(2.0), 2.0)])
def test_the_grid_backend_has_nominal_costs(backend: Backend, size: float) -> None:
    assert action_costs(SECONDS, backend) == (1, 1, 1, 1)
    moving, standing = (nominal_joules(size, moving=moving) for moving in (True, False))
    assert action_costs(JOULES, backend) == (moving, moving, standing, standing)
    assert moving > standing


def test_unknown_measures_and_backends_are_errors() -> None:
    with pytest.raises(ValueError, match="cost is 'metres'; allowed: steps, seconds, joules"):
        action_costs("metres")
    with pytest.raises(BackendError, match="no backend is called 'hover'"):
        action_costs(SECONDS, "hover")


class SlowToStart(GridMotion):
    """Takes 1 s to stand, 2 s to move, 4 s more with an item, 100 s more for the first action."""

    def reset(self, layout: Layout, cells: Sequence[Cell], seed: int | None) -> None:
        super().reset(layout, cells, seed)
        self.delay = 100.0

    def advance(self, displacements: Sequence[Cell], loaded: Sequence[bool]) -> list[Outcome]:
        seconds = 1.0 + (displacements[0] != (0, 0)) + 4 * loaded[0] + self.delay
        self.delay = 0.0
        return [super().advance(displacements, loaded)[0]._replace(seconds=seconds)]


def test_the_second_move_and_a_loaded_drop_are_measured() -> None:
    costs = action_costs(SECONDS, SlowToStart)
    assert costs == ActionCosts(move_empty=2, move_loaded=6, pick=1, drop=5)


@pytest.mark.parametrize("measure", [SECONDS, JOULES])
@pytest.mark.parametrize("backend", ["grid", "physics"])
def test_a_straight_delivery_has_the_planned_cost(measure: str, backend: str) -> None:
    costs = action_costs(measure, backend)
    problem = DeliveryProblem(LANE, (1, 1), costs=costs)
    plan = astar_search(problem, manhattan_delivery(problem))
    assert plan.actions == ("E", "E", "E", "PICK", "E", "E", "E", "E", "DROP")
    env = WarehouseEnv(LANE, backend=backend)
    measured = 0.0
    for action in plan.actions:
        _, _, terminated, _, _ = env.step(action)
        assert env.last_motion is not None
        measured += getattr(env.last_motion, measure)
    assert terminated
    assert plan.cost == pytest.approx(measured, rel=0.02)
