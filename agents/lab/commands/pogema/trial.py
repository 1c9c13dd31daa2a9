"""One episode of POGEMA's benchmark, run by one planner."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from agents.lab.commands.planners.runs import attempt, make_stepper
from agents.lab.commands.pogema.benchmark import Instance, Kind
from agents.mapf.graph import Graph
from agents.mapf.lifelong import lead
from agents.mapf.problem import Problem

SEED = 0
"""Seed of the planners that draw."""


class Outcome(NamedTuple):
    """What a planner has reached in an episode.

    Attributes:
        steps: makespan of the plan, -1 without one, or the steps of a lifelong episode.
        costs: sum of the costs of the robots, 0 without a plan.
        bound: sum of the shortest ways from starts to goals, 0 in a lifelong episode.
        proved: 1 if the planner has proved that no plan has lower costs, otherwise 0.
        goals: goals that were reached in a lifelong episode.
        late: steps that took longer than ``--plan-seconds``.
        seconds: processor time of the planner.
    """

    steps: int
    costs: int
    bound: int
    proved: int
    goals: int
    late: int
    seconds: float


def run_instance(instance: Instance, planner: str, seconds: float) -> Outcome:
    """Return what a planner reaches, if a plan or each step of it may take so many seconds."""
    graph = Graph(instance.layout)
    if instance.kind is Kind.LIFELONG:
        # Pickups tell planners that learn where goals are; ways lead through them.
        known = instance.layout.with_tiles(instance.layout.cells(instance.targets), [], [])
        stepper = make_stepper(planner, SEED, known, instance.robots, seconds)
        starts, goals = np.array(instance.starts), np.array(instance.goals)
        run = lead(stepper, starts, goals, instance.new_goals(), instance.steps)
        took = float(run.seconds.sum())
        return Outcome(instance.steps, 0, 0, 0, run.reached, len(stepper.lost), took)
    problem = Problem(graph, instance.starts, instance.goals)
    steps, costs, bound, proved, took = attempt(planner, SEED, problem, seconds)
    if steps is None or costs is None:
        return Outcome(-1, 0, bound, 0, 0, 0, took)
    return Outcome(steps, costs, bound, int(proved), 0, 0, took)
