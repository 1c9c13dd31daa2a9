"""Bodies that execute joint plans."""

import math

import numpy as np
import pytest

from agents.errors import PlanError
from agents.mapf import execution
from agents.mapf.execution import EXECUTIONS, drive_steps, drive_through
from agents.mapf.graph import Graph
from agents.mapf.pibt import PIBT
from agents.mapf.planner import solve_by_steps
from agents.mapf.problem import Plan, Problem
from warehouse_core import Layout, random_layout
from warehouse_physics import Disturbances, RobotSpec, Stop

CORRIDOR = Layout(["." * 6])
ALONG = np.arange(5)[:, None]
"""A plan for a robot that drives four cells east."""


@pytest.mark.parametrize(("execute", "seconds"), [(drive_through, 5.0), (drive_steps, 8.0)])
def test_a_lone_robot_takes_its_time_and_energy(execute, seconds: float) -> None:
    found = execute(CORRIDOR, ALONG)
    assert (found.seconds, found.hits) == (pytest.approx(seconds), 0)
    assert found.arrivals == pytest.approx([seconds])
    spec = RobotSpec()
    starts = 1 if execute is drive_through else 4
    # Drag also brakes: the motor does no work on the last half metre of each start.
    work = starts * spec.mass / 2 + spec.drag_force(False) * (4 - starts / 2)
    joules = work / spec.drivetrain_efficiency + spec.idle_power * seconds
    assert found.joules == pytest.approx(joules, rel=2e-3)


@pytest.mark.parametrize("execute", EXECUTIONS.values())
def test_robots_that_have_arrived_wait_for_the_others_and_their_computers_run(execute) -> None:
    plan = np.array([[0, 5], [1, 5], [2, 4], [2, 4]])
    found = execute(CORRIDOR, plan)
    alone = [execute(CORRIDOR, plan[:, [robot]]) for robot in range(2)]
    assert found.seconds == max(found.arrivals) == found.arrivals[0]
    motors = sum(each.joules - 20 * each.seconds for each in alone)
    assert found.joules == pytest.approx(motors + 2 * 20 * found.seconds)
    still = execute(CORRIDOR, np.array([[0, 3]] * 3))
    assert (still.seconds, still.joules, still.arrivals.tolist()) == (0.0, 0.0, [0.0, 0.0])


def test_a_plan_is_driven_through_faster_and_with_less_energy() -> None:
    layout = random_layout(9, 9, 0.1, seed=3)
    stream = np.random.default_rng(0)
    starts, goals = (stream.permutation(layout.open_cells)[:8].tolist() for _ in range(2))
    problem = Problem(Graph(layout), starts, goals)
    plan = solve_by_steps(PIBT(problem.graph), problem, 10.0)
    driven, stepped = drive_through(layout, plan.cells), drive_steps(layout, plan.cells)
    assert stepped.seconds == pytest.approx(2.0 * plan.makespan)
    assert driven.seconds < 0.8 * stepped.seconds
    assert driven.joules < 0.8 * stepped.joules
    assert driven.hits == stepped.hits == 0
    assert driven.arrivals.shape == (8,)


def test_a_plan_with_a_conflict_is_refused() -> None:
    with pytest.raises(ValueError, match=r"robots 0 and 1 cannot swap the cells"):
        drive_through(CORRIDOR, Plan.of([[0, 1], [1, 0]]).cells)


def test_robots_wait_for_one_that_has_stopped_for_a_while() -> None:
    plan = np.array([[0, 2], [1, 3], [2, 4], [3, 5]])
    late = Disturbances(stops=(Stop(1, 0.5, 10.0),))
    found = drive_through(CORRIDOR, plan, None, late)
    assert found.seconds > 10
    assert found.hits == 0


def test_robots_behind_one_that_has_died_are_named() -> None:
    plan = np.array([[0, 2, 5], [1, 3, 5], [2, 4, 5]])
    dead = Disturbances(stops=(Stop(1, 0.5, math.inf),))
    with pytest.raises(PlanError, match=r"after \d+ s robots 0 and 1 have not arrived"):
        drive_through(CORRIDOR, plan, None, dead)


def test_robots_that_get_nowhere_though_they_move_are_named(monkeypatch) -> None:
    monkeypatch.setattr(execution, "MAX_SLOWNESS", 0.1)
    monkeypatch.setattr(execution, "PATIENCE", 1.5)
    with pytest.raises(PlanError, match="after 3 s robot 0 has not arrived"):
        drive_through(CORRIDOR, ALONG)


def test_a_robot_that_has_no_force_for_a_step_is_named() -> None:
    weak = Disturbances(motor_strength=0.05)
    with pytest.raises(PlanError, match="in joint step 0 robot 0 has not arrived"):
        drive_steps(CORRIDOR, ALONG, None, weak)


def test_robots_try_a_step_again_from_which_a_disturbance_has_kept_them() -> None:
    weak = Disturbances(motor_strength=0.3, patience=1.0)
    found = drive_steps(CORRIDOR, ALONG, None, weak)
    assert found.seconds > drive_steps(CORRIDOR, ALONG).seconds
