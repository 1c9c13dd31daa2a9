"""Guidance: costs of moves that make robots avoid one another, for lanes or learned from traffic.

Moves against a lane, or against the traffic, are allowed but cost more, so that every reachable
cell stays reachable. Lanes are also called highways.

Sources: Cohen, Uras and Koenig (2015), Feasibility study: using highways for bounded-suboptimal
multi-agent path finding, SoCS. Zhang, Jiang, Bhatt, Nikolaidis and Li (2024), Guidance graph
optimization for lifelong multi-agent path finding, IJCAI. Chen, Harabor, Li and Stuckey (2024),
Traffic flow optimisation for lifelong multi-agent path finding, AAAI.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from agents.mapf.graph import CLOSED, Costs, Graph
from agents.mapf.lifelong import run_lifelong
from agents.mapf.pibt import PIBT
from warehouse_core.world.actions import ACTIONS, WAIT
from warehouse_core.world.layout import Layout
from warehouse_core.world.tables import Integers

__all__ = ["lane_costs"]

WRONG_WAY = 5.0
"""Cost of a move against its lane."""

FIRST_WRONG_WAY = 1.5
"""Cost of a move against its lane in the first trial of learned costs."""

MOVE_COST, OPPOSED_COST, WAIT_COST = 2.0, 10.0, 2.0
"""Costs that traffic adds to a move, per step and occurrence.

They apply to the same move, to the opposite move, and to a robot that waits in the cell to which
the move leads. Robots that meet head-on lose most time.
"""

MIN_SHARE = 0.15
"""Smallest weight of the latest trial in the mean traffic, so that late trials still count."""

TRIAL_SEED = 1_000_000
"""Seed of the first trial, which no episode uses."""

TRIALS, TRIAL_STEPS = 8, 128
"""Number of trials and steps of each.

With twice as many of both, windowed plans reach as many goals (6.23 and 6.17 per step on the kiva
layout with 192 robots, 13.5 and 13.5 on 32 x 32 cells with 400), but learning takes four times as
long.
"""


class Learned(NamedTuple):
    """Learned costs, and the ratio of the goals that PIBT reaches with them to those without."""

    costs: Costs
    gain: float


def lane_costs(layout: Layout, wrong_way: float = WRONG_WAY) -> Costs:
    """Return the costs of the moves N, E, S and W from each cell, ``[H * W, 4]``, for a ``Graph``.

    These moves are against a lane and cost ``wrong_way``: west in an even row, east in an odd row,
    north in an even column, and south in an odd column. All other moves cost 1.

    Example:
        >>> from agents.mapf.graph import Graph
        >>> from agents.mapf.guidance import lane_costs
        >>> from agents.mapf.pibt import PIBT
        >>> from warehouse_core import shelf_layout
        >>> layout = shelf_layout(aisle=2)
        >>> planner = PIBT(Graph(layout, lane_costs(layout)))
    """
    costs = np.ones((layout.height, layout.width, 4), np.float32)
    north, east, south, west = map(ACTIONS.index, "NESW")
    costs[0::2, :, west] = costs[1::2, :, east] = wrong_way
    costs[:, 0::2, north] = costs[:, 1::2, south] = wrong_way
    return costs.reshape(-1, 4)


def learned_costs(
    layout: Layout, robots: int, trials: int = TRIALS, steps: int = TRIAL_STEPS, seed: int = 0,
    starts: Integers | None = None, goals: Integers | None = None,
) -> Costs:  # fmt: skip
    """Return costs of moves learned from the traffic of trial runs, in the form of ``lane_costs``.

    In each trial, PIBT moves the robots with the current costs, which are weak lanes at first. The
    new costs follow from the mean traffic of the trials, and are highest where robots would meet
    head-on. The first trial has the given seed, and each next trial the next seed. See
    ``run_lifelong`` for the other arguments and for errors.
    """
    costs = lanes = lane_costs(layout, FIRST_WRONG_WAY)
    floor, opposite = Graph(layout), np.roll(np.arange(WAIT), 2)
    reached, mean = floor.neighbours[:, :WAIT], np.zeros((floor.size, WAIT + 1))
    is_move = reached != CLOSED
    for trial in range(seed, seed + trials):
        graph = Graph(layout, costs)
        run = run_lifelong(graph, PIBT(graph, trial), robots, steps, trial, starts, goals)
        share = max(1 / (trial - seed + 1), MIN_SHARE)
        mean += (traffic(graph, run.cells) - mean) * share
        back, waiting = (np.where(is_move, mean[reached, at], 0) for at in (opposite, WAIT))
        more = MOVE_COST * mean[:, :WAIT] + (OPPOSED_COST * back + WAIT_COST * waiting)
        costs = np.round(lanes + more, 1).astype(np.float32)
    return costs


@lru_cache(maxsize=16)
def learn(layout: Layout, robots: int) -> Learned:
    """Return costs learned for a fleet, whose goals are stations, half of them dropoffs.

    The result is cached for the process, and its costs must not be changed.
    """
    goals = station_goals(layout)
    if len(layout.open_cells) < 2:  # nobody can move
        return Learned(lane_costs(layout, FIRST_WRONG_WAY), 1.0)
    costs = learned_costs(layout, robots, seed=TRIAL_SEED, goals=goals)
    costs.flags.writeable = False
    reached = [
        run_lifelong(graph, PIBT(graph), robots, TRIAL_STEPS, TRIAL_SEED, goals=goals).reached
        for graph in (Graph(layout, costs), Graph(layout))
    ]
    return Learned(costs, reached[0] / max(reached[1], 1))


def station_goals(layout: Layout) -> Integers | None:
    """Return pickups and dropoffs, repeated so that each kind is half of the goals, or ``None``."""
    pickups, dropoffs = (layout.numbers(cells) for cells in (layout.pickups, layout.dropoffs))
    goals = np.concatenate(
        [np.tile(pickups, max(len(dropoffs), 1)), np.tile(dropoffs, max(len(pickups), 1))]
    )
    return goals if len(goals) > 1 else None


def traffic(graph: Graph, cells: Integers) -> NDArray[np.float64]:
    """Return how often in a step each move and waiting occurred, ``[H * W, 5]``.

    ``cells`` has the cells of the robots before each step and after the last, ``[T + 1, R]``.
    """
    before, after = cells[:-1].ravel(), cells[1:].ravel()
    moves = (graph.neighbours[before] == after[:, None]).argmax(1)
    made = (before * (WAIT + 1) + moves).astype(np.intp)  # 32 bits in a browser
    counts = np.bincount(made, minlength=graph.size * (WAIT + 1))
    return counts.reshape(-1, WAIT + 1) / (len(cells) - 1)
