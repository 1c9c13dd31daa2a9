"""The plans of a fleet's planner, step by step, which a replay shows together with the record."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from warehouse_core.records.episode import FleetEpisode
from warehouse_core.world.tiles import Cell


class StepPlans(NamedTuple):
    """The plans of some robots before a joint step.

    Attributes:
        paths: cells of each robot's plan, one for each step, beginning with its own cell.
        wishes: cells of the path from the end of each robot's plan to its goal, as if no other
            robot were in the way.
        pushers: robot that pushed another one, by the number of the pushed robot, which had to
            choose its next cell before its turn; see ``PIBT``.
    """

    paths: Mapping[int, Sequence[Cell]] = {}
    wishes: Mapping[int, Sequence[Cell]] = {}
    pushers: Mapping[int, int] = {}


NO_PLANS = StepPlans()


def check_plans(plans: Sequence[StepPlans], episode: FleetEpisode) -> None:
    """Check that plans fit an episode.

    Raises:
        ValueError: there are more plans than frames, or a robot or cell does not exist.
    """
    if len(plans) > episode.steps + 1:
        raise ValueError(
            f"{len(plans)} plans for {episode.steps} steps; allowed: at most {episode.steps + 1}"
        )
    height, width = episode.layout.height, episode.layout.width
    for step, (paths, wishes, pushers) in enumerate(plans):
        for robot in (*paths, *wishes, *pushers, *pushers.values()):
            if not 0 <= robot < episode.robots:
                raise ValueError(
                    f"plan {step}: there is no robot {robot}; allowed: 0..{episode.robots - 1}"
                )
        for row, col in (cell for path in (*paths.values(), *wishes.values()) for cell in path):
            if not (0 <= row < height and 0 <= col < width):
                raise ValueError(
                    f"plan {step}: cell {(row, col)} is not in the layout of {height} rows and "
                    f"{width} columns"
                )
