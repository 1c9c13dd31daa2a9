"""Guidance learned from traffic: costs of moves that make robots avoid one another.

Moves against the traffic are allowed but cost more, as moves against a lane do.

Sources: Zhang, Jiang, Bhatt, Nikolaidis and Li (2024), Guidance graph optimization for lifelong
multi-agent path finding, IJCAI. Chen, Harabor, Li and Stuckey (2024), Traffic flow optimisation for
lifelong multi-agent path finding, AAAI.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from agents.mapf.circulation import Circulation
from agents.mapf.graph import CLOSED, Costs, Graph
from agents.mapf.lanes import lane_costs
from agents.mapf.lifelong import run_lifelong
from agents.mapf.pibt import PIBT
from agents.mapf.planner import Planner
from warehouse_core.arguments import instance_of, real_number, whole_number
from warehouse_core.world.actions import WAIT
from warehouse_core.world.layout import Layout
from warehouse_core.world.tables import Integers

__all__ = ["directed_costs", "learned_costs"]

FIRST_WRONG_WAY = 1.5
"""Cost of a move against its lane in the first trial of learned costs."""

MOVE_COST, OPPOSED_COST, WAIT_COST = 2.0, 10.0, 2.0
"""Costs that traffic adds to a move, per step and occurrence.

They apply to the same move, to the opposite move, and to a robot that waits in the cell to which
the move leads. Robots that meet head-on lose most time.
"""

FIRST_DIRECTED = 3.0
"""Cost of a move against its lane in the first trial of directed costs, at most ``wrong_way``."""

MIN_SHARE = 0.15
"""Smallest weight of the latest trial in the mean traffic, so that late trials still count."""

FEW = 0.003
"""Moves per step between two cells below which they hardly define a direction."""

TRIAL_SEED = 1_000_000
"""Seed of the first trial, which no episode uses."""

MAX_TRIALS = 1000
"""Limit on the number of trials."""

DIRECTED_WRONG_WAY, DIRECTED_TRIALS, DIRECTED_STEPS = 9.0, 24, 600
"""Defaults of directed costs: cost of a move against all traffic, trials, and steps of a trial."""

Shares = NDArray[np.float64]


def learned_costs(
    layout: Layout,
    robots: int,
    trials: int = 16,
    steps: int = 256,
    seed: int = 0,
    starts: Integers | None = None,
    goals: Integers | None = None,
) -> Costs:
    """Return costs of moves learned from the traffic of trial runs, in the form of ``lane_costs``.

    In each trial, PIBT moves the robots with the current costs, which are weak lanes at first. The
    new costs follow from the mean traffic of the trials, and are highest where robots would meet
    head-on. The first trial has the given seed, and each next trial the next seed. See
    ``run_lifelong`` for the other arguments and for errors.

    Example:
        >>> from agents.mapf.traffic import learned_costs
        >>> from warehouse_core import shelf_layout
        >>> learned_costs(shelf_layout(aisle=2), robots=8, trials=2, steps=20).shape
        (220, 4)
    """
    return Traffic(layout).learned(PIBT, robots, trials, steps, seed, starts=starts, goals=goals)


def directed_costs(
    layout: Layout,
    robots: int,
    wrong_way: float = DIRECTED_WRONG_WAY,
    trials: int = DIRECTED_TRIALS,
    trial_seed: int = TRIAL_SEED,
) -> Costs:
    """Return costs of moves that make a crowded floor one-way, in the form of ``lane_costs``.

    In each trial, circulations move robots with headings with the current costs, which are lanes at
    first. The cost of a move then grows with the share of the opposite move in all moves between
    the two cells. The result is cached for the process and must not be changed.

    Args:
        layout: floor; robots drive between its stations, see ``station_goals``.
        robots: number of robots.
        wrong_way: cost of a move against all traffic, 1 or more; with the traffic a move costs 1.
        trials: number of trials, at most ``MAX_TRIALS``.
        trial_seed: seed of the first trial; each next trial has the next seed.

    Raises:
        PlanError: as for ``run_lifelong``.
        ValueError: an argument is out of range.

    Example:
        >>> from agents.mapf.traffic import directed_costs
        >>> from warehouse_core import random_layout
        >>> directed_costs(random_layout(6, 6, 0.1, seed=1), robots=12, trials=1).shape
        (36, 4)
    """
    return directions(
        instance_of("layout", layout, Layout),
        whole_number("robots", robots, 1),
        real_number("wrong_way", wrong_way, 1.0),
        whole_number("trials", trials, 1, MAX_TRIALS),
        whole_number("trial_seed", trial_seed, 0),
    )


@lru_cache(maxsize=16)
def directions(layout: Layout, robots: int, wrong_way: float, trials: int, seed: int) -> Costs:
    """Return the result of ``directed_costs`` for arguments that have been checked."""
    if len(layout.open_cells) < 2:
        trials = 0  # nobody can move
    costs = Directions(layout, wrong_way).learned(
        Circulation, robots, trials, DIRECTED_STEPS, seed, goals=station_goals(layout),
        has_headings=True,
    )  # fmt: skip
    costs.flags.writeable = False
    return costs


def station_goals(layout: Layout) -> Integers | None:
    """Return pickups and dropoffs, repeated so that each kind is half of the goals, or ``None``."""
    pickups, dropoffs = (layout.numbers(cells) for cells in (layout.pickups, layout.dropoffs))
    goals = np.concatenate(
        [np.tile(pickups, max(len(dropoffs), 1)), np.tile(dropoffs, max(len(pickups), 1))]
    )
    return goals if len(goals) > 1 else None


class Traffic:
    """Costs of moves that follow from the mean traffic of trials, and are lanes at first.

    Attributes:
        costs: ``[H * W, 4]``, see ``lane_costs``.
    """

    def __init__(self, layout: Layout, wrong_way: float = FIRST_WRONG_WAY) -> None:
        self._graph, self._trials = Graph(layout), 0
        self.costs = self._lanes = lane_costs(layout, wrong_way)
        self._mean = np.zeros((self._graph.size, WAIT + 1))

    def learned(
        self, make: Callable[[Graph, int], Planner], robots: int, trials: int, steps: int,
        seed: int, **others: Any,
    ) -> Costs:  # fmt: skip
        """Return the costs after some trials; see ``run_lifelong`` for ``others``.

        The planner of each trial is made from its seed and a graph with the current costs.
        """
        for trial in range(seed, seed + trials):
            graph = Graph(self._graph.layout, self.costs)
            run = run_lifelong(graph, make(graph, trial), robots, steps, trial, **others)
            self.add(run.cells)
        return self.costs

    def add(self, cells: Integers) -> None:
        """Add a trial, given the cells of its robots before each step and after the last."""
        self._trials += 1
        share = max(1 / self._trials, MIN_SHARE)
        self._mean += (traffic(self._graph, cells) - self._mean) * share
        reached, opposite = self._graph.neighbours[:, :WAIT], np.roll(np.arange(WAIT), 2)
        is_move = reached != CLOSED
        there, back = self._mean[:, :WAIT], np.where(is_move, self._mean[reached, opposite], 0)
        waiting = np.where(is_move, self._mean[reached, WAIT], 0)
        self.costs = np.round(self._priced(there, back, waiting), 1).astype(np.float32)

    def _priced(self, there: Shares, back: Shares, waiting: Shares) -> Shares:
        """Return the costs of moves; the result and all arguments are ``[H * W, 4]``.

        Args:
            there: number of times per step that each move is made.
            back: number of times per step that the opposite move is made.
            waiting: number of times per step that a robot waits in the cell to which the move
                leads.
        """
        return self._lanes + (MOVE_COST * there + (OPPOSED_COST * back + WAIT_COST * waiting))


class Directions(Traffic):
    """Costs of moves that are high where most robots move in the opposite direction."""

    def __init__(self, layout: Layout, wrong_way: float) -> None:
        super().__init__(layout, min(wrong_way, FIRST_DIRECTED))
        self._against = wrong_way - 1

    def _priced(self, there: Shares, back: Shares, waiting: Shares) -> Shares:
        """Return the costs of moves: 1 with all traffic, ``1 + _against`` against all traffic."""
        share = (back + FEW / 2) / (there + back + FEW)
        return 1 + self._against * share**2


def traffic(graph: Graph, cells: Integers) -> NDArray[np.float64]:
    """Return how often in a step each move and waiting occurred, ``[H * W, 5]``.

    ``cells`` has the cells of the robots before each step and after the last, ``[T + 1, R]``.
    """
    before, after = cells[:-1].ravel(), cells[1:].ravel()
    moves = (graph.neighbours[before] == after[:, None]).argmax(1)
    made = (before * (WAIT + 1) + moves).astype(np.intp)  # 32 bits in a browser
    counts = np.bincount(made, minlength=graph.size * (WAIT + 1))
    return counts.reshape(-1, WAIT + 1) / (len(cells) - 1)
