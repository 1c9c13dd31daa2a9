"""Optimum of a shift: the largest number of orders that any fleet could deliver, or a bound on it.

The robots of this model take the shortest path between two cells, with one step for each cell, and
one step each to pick and to drop. They never meet, wait for people or charge. They know all orders
from the start, and any robot may take any order. Therefore no fleet on the same floor delivers
more, whatever its assignment, and a fleet whose robots never block one another can deliver as many.

The model is a flow of robots over time. A robot at a pickup waits there or takes a released order.
The order takes it to the dropoff, from which it goes to any pickup. The size of the model hardly
depends on the number of robots, because the robots are interchangeable. Each order is taken at most
once. The number of robots in each move must be an integer, which makes the model an integer
program. Its linear relaxation gives a bound.

Source: Ford and Fulkerson (1958), Constructing maximal dynamic flows from static flows. The solver
is HiGHS: Huangfu and Hall (2018), Parallelizing the dual revised simplex method.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from agents.mapf.assignment import HANDLING
from agents.mapf.graph import Fields, Graph
from agents.mapf.kernels.places import NONE
from warehouse_core import Episode, OrderQueue
from warehouse_core.wording import brief
from warehouse_core.world.tables import Integers

__all__ = ["most_deliveries"]

MAX_MOVES = 100_000
"""Number of moves of a flow beyond which time is counted in units of several steps."""

MAX_EXACT = 6_000
"""Number of moves of a flow up to which an integer solution is searched."""

MAX_NODES = 100
"""Limit on the nodes of the integer search. A limit in seconds would not be repeatable."""

ERROR = 1e-4
"""Tolerance of the solver, by which its maximum may be too low."""

INFEASIBLE = 2
"""Status code of SciPy's solver for a program without a solution."""


class Optimum(NamedTuple):
    """The largest number of deliveries that was possible in a shift.

    Attributes:
        most: number of orders; no fleet delivers more.
        is_exact: true if robots that never meet can deliver ``most``; false if it is an upper
            bound.
    """

    most: int
    is_exact: bool


class Jobs(NamedTuple):
    """The orders of a shift and the distances between their ``P`` pickups and ``D`` dropoffs.

    Attributes:
        pickup, dropoff: ``[K]``, numbers of the stations of each of ``K`` orders.
        first, last: ``[K]``, earliest and latest step in which a robot can begin to pick each
            order.
        takes: ``[K]``, steps from picking each order until its delivery.
        distances: ``[P, D + R]``, steps to each pickup from each dropoff and each start.
        robots: ``R``, number of robots.
    """

    pickup: Integers
    dropoff: Integers
    first: Integers
    last: Integers
    takes: Integers
    distances: Integers
    robots: int

    @property
    def until(self) -> Integers:
        """``[P]``, the last step in which an order can be picked, negative if none can."""
        until = np.full(len(self.distances), -1)
        np.maximum.at(until, self.pickup, self.last)
        return until


class Flow(NamedTuple):
    """The ``M`` moves of robots between ``N`` nodes, each of which is a place at a time.

    Attributes:
        tails, heads: ``[M]``, nodes from and to which the moves lead.
        order: ``[M]``, order that each move delivers, or ``NONE``.
        time: ``[M]``, time at which each move ends.
        robots: ``[N]``, number of robots that begin in each node.
    """

    tails: Integers
    heads: Integers
    order: Integers
    time: Integers
    robots: Integers


def most_deliveries(shift: Episode, on_time: bool = False) -> Optimum:
    """Return the largest number of orders of a shift that could have been delivered in its steps.

    Args:
        shift: record of a fleet, whose robots begin in the same cells.
        on_time: count only deliveries that are not late.

    Raises:
        ValueError: the record is of a single robot or of a fleet without orders. Or its orders are
            an ``OrderQueue``, in which each order depends on earlier deliveries.

    Example:
        >>> from agents.fleet.optimum import most_deliveries
        >>> from agents.registry import make_team
        >>> from warehouse_core import FleetEnv, record_episode, shelf_layout
        >>> env = FleetEnv(shelf_layout(aisle=2), 2, orders=0.1, max_steps=50, seed=1)
        >>> shift = record_episode(env, make_team("greedy", 2, 1, env.layout), seed=1)
        >>> shift.measures.delivered, most_deliveries(shift)
        (0, Optimum(most=2, is_exact=True))
    """
    orders = shift.settings.orders if shift.is_fleet else None
    if orders is None or isinstance(orders, OrderQueue):
        raise ValueError(
            f"the orders of this shift are {brief(orders)}; an optimum needs a list or streams, "
            "which come whatever the fleet does"
        )
    jobs = _jobs(shift, on_time)
    if (jobs.last < jobs.first).all():
        return Optimum(0, is_exact=True)
    moves = np.maximum(jobs.last + 1 - jobs.first, 0).sum()
    moves += np.maximum(jobs.until[:, None] + 1 - jobs.distances[:, : -jobs.robots], 0).sum()
    unit = 1 + int(moves) // MAX_MOVES
    flow = _flow(jobs, unit)
    return _solve(flow, exactly=unit == 1 and len(flow.order) <= MAX_EXACT)


def _jobs(shift: Episode, on_time: bool) -> Jobs:
    layout, orders = shift.layout, shift.orders
    ends = [[order.pickup for order in orders], [order.dropoff for order in orders]]
    (pickups, pickup), (dropoffs, dropoff) = (
        np.unique(layout.numbers(cells), return_inverse=True) for cells in ends
    )
    fields = Fields(Graph(layout))
    rows = fields.rows(pickups)
    distances = fields.matrix[rows].astype(np.intp)
    takes = distances[pickup, dropoffs[dropoff]] + HANDLING
    due = [min(order.due, shift.steps) if on_time else shift.steps for order in orders]
    first, last = np.array([order.released for order in orders], np.intp), np.array(due, np.intp)
    distances = distances[:, np.concatenate([dropoffs, shift.cells[0]])]
    return Jobs(pickup, dropoff, first, last - takes, takes, distances, shift.robots)


def _flow(jobs: Jobs, unit: int) -> Flow:
    """Return the flow, with all times rounded down to units of some steps.

    Rounding shortens paths and lets orders wait longer, so that every possible delivery remains
    possible.
    """
    until = jobs.until // unit
    units = int((jobs.last + jobs.takes).max(initial=0)) // unit + 1
    places, starts = sum(jobs.distances.shape), jobs.distances.shape[1] - jobs.robots
    moves = list[Integers]()

    def add(tail: int, head: int, times: Integers, steps: int, order: int = NONE) -> None:
        ends = times + steps // unit
        columns = tail * units + times, head * units + ends, order, ends
        moves.append(np.array(np.broadcast_arrays(*columns)))

    for order, (pickup, dropoff, first, last, takes) in enumerate(zip(*jobs[:5], strict=True)):
        times = np.arange(first // unit, last // unit + 1)
        add(pickup, len(jobs.distances) + dropoff, times, takes, order)
    for pickup, row in enumerate(jobs.distances):
        add(pickup, pickup, np.arange(until[pickup]), unit)
        for place, distance in enumerate(row):
            times = np.arange(until[pickup] + 1 - distance // unit)
            times = times[:1] if place >= starts else times
            add(len(jobs.distances) + place, pickup, times, distance)
    robots = np.zeros((places, units), np.intp)
    robots[len(jobs.distances) + starts :, 0] = 1
    tails, heads, orders, ends = np.concatenate(moves, axis=1)
    return Flow(tails, heads, orders, ends, robots.ravel())


def _solve(flow: Flow, exactly: bool) -> Optimum:
    """Return the optimum if ``exactly`` is true and it is found, otherwise the linear bound.

    The candidates are the whole numbers from the bound down, until an integer solution exists. The
    objective prefers early deliveries, because otherwise the search would visit many equal flows.
    """
    from scipy.optimize import Bounds, LinearConstraint, linprog, milp
    from scipy.sparse import csr_array, vstack

    count, orders, delivers = len(flow.order), 1 + flow.order.max(), flow.order != NONE
    each, ones = np.arange(count), np.ones(count)
    leaving = csr_array((ones, (flow.tails, each)), (len(flow.robots), count))
    entering = csr_array((ones, (flow.heads, each)), (len(flow.robots), count))
    taking = csr_array((ones[delivers], (flow.order[delivers], each[delivers])), (orders, count))
    matrix = vstack([leaving - entering, taking], format="csr")
    limits = np.concatenate([flow.robots, np.ones(orders)])
    is_used = np.diff(matrix.indptr) > 0
    matrix, limits = matrix[is_used], limits[is_used]
    bound = linprog(-1.0 * delivers, A_ub=matrix, b_ub=limits, method="highs-ipm")
    most = int(ERROR - bound.fun) if bound.success else int(orders)
    while exactly:
        enough = LinearConstraint(csr_array(delivers[None].astype(float)), most, np.inf)
        result = milp(
            np.where(delivers, 1 + flow.time, 0),
            integrality=delivers,
            bounds=Bounds(0, np.inf),
            constraints=[LinearConstraint(matrix, -np.inf, limits), enough],
            options={"node_limit": MAX_NODES, "mip_rel_gap": 1e6},
        )
        if result.x is not None:
            return Optimum(most, is_exact=True)
        if result.status != INFEASIBLE:
            break
        most -= 1
    return Optimum(most, is_exact=False)
