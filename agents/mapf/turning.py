"""Plans for robots with headings, made from plans for robots that move in four directions."""

from __future__ import annotations

import numpy as np

from agents.mapf.graph import robots_in
from agents.mapf.kernels.robots import NOBODY
from agents.mapf.problem import Plan, Problem
from warehouse_core.world.actions import WAIT
from warehouse_core.world.moves import HEADINGS
from warehouse_core.world.tables import Integers


def with_turns(problem: Problem, plan: Plan) -> Plan:
    """Return the plan for robots with headings that follows from a plan without headings.

    Each robot passes the cells of the given plan, and the robots pass each cell in the order of the
    given plan, so that all arrive. Apart from that, each robot turns and moves as soon as possible.
    """
    graph, cells = problem.graph, plan.cells
    robots = cells.shape[1]
    mover, time = np.nonzero((cells[1:] != cells[:-1]).T)
    here, to = cells[time, mover], cells[time + 1, mover]
    course = (graph.neighbours[here, :WAIT] == to[:, None]).argmax(axis=1)
    before = visits_before(cells[0], to, time)
    move, end = np.searchsorted(mover, [np.arange(robots), np.arange(1, robots + 1)])
    cell, headings = cells[0].copy(), np.array(problem.headings, np.intp)
    left = np.zeros(graph.size, np.intp)  # finished visits of each cell
    robot_in = robots_in(graph.size, cell)
    all_cells, all_headings = [cell.copy()], [headings.copy()]
    while (active := np.flatnonzero(move < end)).size:
        quarters = (course[move[active]] - headings[active]) % len(HEADINGS)
        ready = active[quarters == 0]
        goes = np.zeros(robots, np.bool_)
        goes[ready] = True
        while True:  # robots in a chain or a ring move at the same time or not at all
            ahead = to[move[ready]]
            missing, front = before[move[ready]] - left[ahead], robot_in[ahead]
            is_free = (missing == 0) | ((missing == 1) & (front != NOBODY) & goes[front])
            if is_free.all():
                break
            goes[ready[~is_free]] = False
            ready = ready[is_free]
        headings[active] += np.where(quarters == len(HEADINGS) - 1, -1, np.sign(quarters))
        headings %= len(HEADINGS)
        left[cell[ready]] += 1
        robot_in[cell[ready]] = NOBODY
        cell[ready] = to[move[ready]]
        robot_in[cell[ready]] = ready
        move[ready] += 1
        all_cells.append(cell.copy())
        all_headings.append(headings.copy())
    return Plan(np.array(all_cells), headings=np.array(all_headings))


def visits_before(starts: Integers, to: Integers, time: Integers) -> Integers:
    """Return the number of visits to each entered cell before the move, including starts."""
    cell = np.concatenate([starts, to])
    when = np.concatenate([np.full(len(starts), -1), time])
    order = np.lexsort((when, cell))
    in_order = cell[order]
    number = np.empty(len(cell), np.intp)
    number[order] = np.arange(len(cell)) - np.searchsorted(in_order, in_order)
    return number[len(starts) :]
