"""A crowded floor on which lanes help: one fleet with the same orders, without lanes and with."""

from __future__ import annotations

from itertools import cycle

from agents.fleet.planned import PlannedFleet
from agents.lab.console.watch import slow_steps_told
from agents.lab.runs.run import run
from agents.mapf.graph import Graph
from agents.mapf.lanes import lane_costs
from agents.mapf.pibt import PIBT
from warehouse_core import Episode, FleetEnv, Layout, OrderStream

SHELF_ROWS, SHELF_COLUMNS, SHELF, MARGIN = 5, 2, 8, 2
"""Rows and columns of shelves, their length, and the cells at both sides of them."""

STATIONS = "PD.."
"""Tiles along shelves, again and again."""

ROBOTS, RATE, STEPS, BATTERY = 60, 6.0, 300, 10_000
"""Orders arrive faster than they can be delivered, and nobody has to charge."""


def crowded_floor() -> Layout:
    """Return rows of shelves between single aisles, with stations above and below them."""
    tiles, ends = cycle(STATIONS), "." * MARGIN

    def row_of(tile: str) -> str:
        shelves = ("".join(tile or next(tiles) for _ in range(SHELF)) for _ in range(SHELF_COLUMNS))
        return f"{ends}{'.'.join(shelves)}{ends}"

    blocks = ((row_of(""), row_of("#"), row_of(""), row_of(".")) for _ in range(SHELF_ROWS))
    return Layout([row_of("."), *(row for block in blocks for row in block)])


def lanes_compared(seed: int = 1, steps: int = STEPS) -> dict[str, Episode]:
    """Return the records of a fleet led by PIBT without and with lanes.

    Args:
        seed: seed of the fleet, its orders and PIBT.
        steps: steps of each episode.
    """
    layout, found = crowded_floor(), {}
    for name, costs in (("Without lanes", None), ("With lanes", lane_costs(layout))):
        env = FleetEnv(
            layout, ROBOTS, orders=OrderStream(RATE), max_steps=steps, battery=BATTERY,
            dispatch=False,
        )  # fmt: skip
        fleet = PlannedFleet(PIBT(Graph(layout, costs), seed), "hungarian")
        found[name] = run(env, fleet, seed, slow_steps_told(fleet, name), name=name)
    return found
