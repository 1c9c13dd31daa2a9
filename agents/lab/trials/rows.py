"""Rows of numbers that summarize an episode of a lone robot or of a fleet."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import NamedTuple

from warehouse_core import Episode
from warehouse_core.records.failure_modes import FLEET_MODES, MODES, diagnose


class Row(NamedTuple):
    """One episode of a lone robot.

    Attributes:
        seed: Seed of the layout, the start and the agent.
        mode: Outcome, see ``warehouse_core/records/failure_modes.py``.
        steps: Number of steps.
        needed: Fewest steps of a delivery; ``None`` if no path exists.
        reward: Total reward.
        battery_left: Battery units at the end.
        seconds: Simulated time in s.
        joules: Energy in J.
        row: Row of the cell where the robot got stuck or the episode ended.
        col: Column of this cell.
    """

    seed: int
    mode: str
    steps: int
    needed: int | None
    reward: float
    battery_left: int
    seconds: float
    joules: float
    row: int
    col: int


class FleetRow(NamedTuple):
    """One episode of a fleet; ``FleetMeasures`` describes the fields that are not listed here.

    Fields are ``None`` if nothing was measured.

    Attributes:
        seed: Seed of the layout, the starts, the orders, the people and the agents.
        mode: Outcome, see ``warehouse_core/records/failure_modes.py``.
    """

    seed: int
    mode: str
    steps: int
    seconds: float
    orders: int
    delivered: int
    per_hour: float | None
    mean_lateness: float | None
    worst_lateness: float | None
    on_time: float | None
    joules: float
    joules_per_delivery: float | None
    blocked_by_wall: int
    blocked_by_robot: int
    blocked_by_person: int
    waits: int
    charging: int
    distance: int
    stranded: int


AnyRow = Row | FleetRow

MODES_OF: dict[type[AnyRow], tuple[str, ...]] = {Row: MODES, FleetRow: FLEET_MODES}
"""Possible outcomes for each type of row, in the order in which they are displayed."""


def row_of(episode: Episode) -> AnyRow:
    """Return the row of an episode, which must have a seed."""
    return fleet_row(episode) if episode.is_fleet else lone_row(episode)


def lone_row(episode: Episode) -> Row:
    """Return the row of an episode of a lone robot."""
    assert episode.seed is not None, "every episode here has a seed"
    diagnosis = diagnose(episode)
    cell = diagnosis.cells[0] if diagnosis.cells else episode.cells[-1]
    return Row(
        episode.seed, diagnosis.mode, episode.steps, diagnosis.needed, episode.total_reward,
        episode.battery[-1], episode.seconds, episode.joules, *cell,
    )  # fmt: skip


def fleet_row(episode: Episode) -> FleetRow:
    """Return the row of an episode of a fleet."""
    mode, measures = diagnose(episode).mode, asdict(episode.measures)
    stored = [measures[name] for name in FleetRow._fields if name in measures]
    measured = [None if math.isnan(value) else value for value in stored]
    return FleetRow._make((episode.seed, mode, *measured))
