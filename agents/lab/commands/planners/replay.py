"""The replay of a plan without running an episode."""

from __future__ import annotations

import math

import numpy as np

from agents.mapf.graph import Graph
from warehouse_core.records.plans import StepPlans
from warehouse_core.viz.tracks.track import FleetFrame, Frame, Pose, Track, middle
from warehouse_core.wording import counted
from warehouse_core.world.tables import Integers

SHOWN_PATHS = 3
"""Number of robots whose paths are shown; they are the last ones to arrive."""

HEADINGS = (-math.pi / 2, 0.0, math.pi / 2, math.pi)
"""Angles of robots that head north, east, south and west, in radians."""


def track_of_plan(
    graph: Graph, cells: Integers, title: str, facing: Integers | None = None
) -> Track:
    """Return the track of a plan, with the paths of the last robots to arrive.

    Args:
        graph: graph of the layout.
        cells: cell of each robot after each step, ``[T + 1, R]``.
        title: title of the track.
        facing: heading of each robot after each step, ``[T + 1, R]``. By default robots head in
            the direction of their last move.
    """
    layout, robots = graph.layout, cells.shape[1]
    is_there = np.logical_and.accumulate((cells == cells[-1])[::-1])[::-1]
    last = np.argsort(is_there.sum(axis=0), kind="stable")[:SHOWN_PATHS].tolist()
    paths = {robot: layout.cells(cells[:, robot]) for robot in last}
    headings: list[float | None] = [None] * robots
    items, battery = (None,) * robots, (1.0,) * robots
    frames = []
    for step, row in enumerate(cells):
        if facing is not None:
            headings = [HEADINGS[heading] for heading in facing[step].tolist()]
        elif step:
            moves = (graph.neighbours[cells[step - 1]] == row[:, None]).argmax(axis=1).tolist()
            headings = [
                HEADINGS[move] if move < len(HEADINGS) else before
                for move, before in zip(moves, headings, strict=True)
            ]
        poses = tuple(
            Pose(middle(cell), heading, loaded=False)
            for cell, heading in zip(layout.cells(row), headings, strict=True)
        )
        plans = StepPlans({robot: path[step:] for robot, path in paths.items()})
        arrived = f"{is_there[step].sum()} of {counted(robots, 'robot')} in their final cells"
        fleet = FleetFrame((), items, battery, plans)
        frames.append(
            Frame(layout.rows, poses, float(step), arrived, clock=float(step), fleet=fleet)
        )
    return Track(frames, {}, title=title)
