"""What a planner meant the robots of a fleet to do, kept beside a record for its replay."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from warehouse_core.records.episode import FleetEpisode
from warehouse_core.world.tiles import Cell


class StepPlans(NamedTuple):
    """The plans of some robots before a joint step.

    Attributes:
        ways: cells of each robot's plan from its own cell on, one for each step.
        wishes: cells from the end of each robot's plan to its goal that it would take if nobody
            were in its way.
        pushers: robot that made each robot choose its next cell before its turn, see ``PIBT``.
    """

    ways: Mapping[int, Sequence[Cell]] = {}
    wishes: Mapping[int, Sequence[Cell]] = {}
    pushers: Mapping[int, int] = {}


NO_PLANS = StepPlans()


def check_plans(plans: Sequence[StepPlans], episode: FleetEpisode) -> None:
    """Raise unless plans fit an episode.

    Raises:
        ValueError: more plans than frames, or a robot or a cell that does not exist.
    """
    if len(plans) > episode.steps + 1:
        raise ValueError(f"{len(plans)} plans for {episode.steps} steps; allowed: one for each")
    height, width = episode.layout.height, episode.layout.width
    for step, (ways, wishes, pushers) in enumerate(plans):
        for robot in (*ways, *wishes, *pushers, *pushers.values()):
            if not 0 <= robot < episode.robots:
                raise ValueError(
                    f"plan {step}: there is no robot {robot}; allowed: 0..{episode.robots - 1}"
                )
        for row, col in (cell for way in (*ways.values(), *wishes.values()) for cell in way):
            if not (0 <= row < height and 0 <= col < width):
                raise ValueError(
                    f"plan {step}: cell {(row, col)} is not in the layout of {height} rows and "
                    f"{width} columns"
                )
