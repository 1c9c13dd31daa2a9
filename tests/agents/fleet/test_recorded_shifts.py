"""Shifts of planned fleets do what is recorded of them, so that no change alters a plan unseen.

Planners weigh distances, waits and charge by constants: doubling nearly any of them moves a robot
in one of these shifts.
After a change that is meant to alter plans, ``python tests/agents/fleet/test_recorded_shifts.py``
writes the record anew, and its difference shows what the change has done to fleets.
"""

import hashlib
import json
from pathlib import Path
from typing import NamedTuple

import pytest

from agents.registry import make_fleet_agent
from warehouse_core import FleetEnv, Layout, OrderStream, record_fleet_episode
from warehouse_core.fleet import Battery
from warehouse_core.world.generators import shelf_layout

RECORD = Path(__file__).parents[2] / "data/recorded_shifts.json"

NARROW = shelf_layout(3, 4, 4, aisle=1, pickups=4, dropoffs=3, chargers=3, seed=1)
WIDE = shelf_layout(2, 3, 4, aisle=2, pickups=4, dropoffs=3, chargers=4, seed=2)


class Shift(NamedTuple):
    """A fleet, and who directs it."""

    layout: Layout
    robots: int
    planner: str
    assignment: str
    battery: int
    orders: OrderStream
    people: int = 0
    steps: int = 400


SHIFTS = {
    "busy": Shift(WIDE, 12, "pibt", "hungarian", 400, OrderStream(0.5, (20, 60))),
    "charging": Shift(WIDE, 16, "pibt", "urgent", 90, OrderStream(0.4, (20, 60)), 0, 800),
    "people": Shift(WIDE, 8, "pibt", "urgent", 150, OrderStream(0.3, (20, 60)), 3),
    "lanes": Shift(NARROW, 10, "pibt-lanes", "urgent", 150, OrderStream(0.3, (30, 90))),
    "learned": Shift(NARROW, 8, "pibt-learned", "nearest", 150, OrderStream(0.2, (30, 90))),
    "windowed": Shift(NARROW, 8, "windowed", "hungarian", 120, OrderStream(0.3, (30, 90)), 1, 250),
}


def outcome(shift: Shift) -> dict[str, float | str]:
    """Return measures of a shift, and a digest of all cells, by which they can be told apart."""
    env = FleetEnv(
        shift.layout, shift.robots, orders=shift.orders, battery=Battery(shift.battery),
        people=shift.people, max_steps=shift.steps,
    )  # fmt: skip
    agent = make_fleet_agent(shift.planner, shift.assignment, 1, shift.layout, shift.robots)
    episode = record_fleet_episode(env, agent, seed=1)
    names = "delivered", "on_time", "distance", "waits", "charging", "blocked_by_robot", "stranded"
    measures = {name: getattr(episode.measures, name) for name in names}
    cells = hashlib.sha256(episode.cells.astype("<i8").tobytes()).hexdigest()
    return measures | {"cells": cells[:16]}


@pytest.mark.parametrize("name", SHIFTS)
def test_a_shift_is_as_recorded(name: str) -> None:
    assert outcome(SHIFTS[name]) == json.loads(RECORD.read_text())[name]


if __name__ == "__main__":
    outcomes = {name: outcome(shift) for name, shift in SHIFTS.items()}
    RECORD.write_text(json.dumps(outcomes, indent=2) + "\n")
