"""Planners by name with guidance as an option, and the choice of a planner for a fleet."""

from __future__ import annotations

from collections.abc import Callable
from inspect import Parameter, Signature, signature
from math import inf
from typing import Any, NamedTuple

import numpy as np

from agents.fleet.charging import costs_around_chargers
from agents.mapf.circulation import Circulation
from agents.mapf.graph import Costs, Graph
from agents.mapf.guidance import lane_costs, learn
from agents.mapf.pibt import PIBT
from agents.mapf.planner import Planner
from agents.mapf.windows import WindowedPlanner
from warehouse_core import Layout
from warehouse_core.arguments import one_of, real_number
from warehouse_core.wording import counted
from warehouse_core.world.moves import COMPASS, TURN

NONE, LANES, LEARNED = "none", "lanes", "learned"
GUIDANCE = NONE, LANES, LEARNED
"""Costs of moves that a planner can follow: none, costs of lanes, or costs learned in trials."""

FEW_ROBOTS, SPARSE = 16, 0.05
"""Number of robots and robots per open cell below which no guidance is tried.

On 32 x 32 cells with 50 robots, windowed plans reach 2.43 goals per step without guidance and 2.38
with it.
"""

WORTHWHILE = 1.25
"""Gain of learned costs in trials with PIBT from which on a planner uses them.

Windowed plans avoid most conflicts anyway. With a gain of 1.12 and 1.19 in trials they lost 2% with
guidance, and with gains of 1.27 to 2.06 they won 10 to 20%.
"""

DENSE = {COMPASS: 0.6, TURN: 0.75}
"""Robots per open cell from which on circulations are as good as windowed plans, and faster.

On 32 x 32 cells with 10% walls, windowed plans and circulations reach 14.2 and 14.2 goals per step
with 400 robots (0.49 per cell), and 15.2 and 15.9 with 600 (0.74).
"""

ROBOT_SECONDS = 3e-5
"""Seconds per robot that a step must have for windowed plans, if planners are compiled.

A step takes 7e-6 s per robot on average, and up to 4e-5 s if it makes new plans. With 256 robots
and 0.01 s per step, windowed plans reach 5.73 goals per step on maps of cities, and circulations
5.38.
"""

STEP_SECONDS = 0.1
"""Default time per step, for which the planner is chosen."""


class Guided:
    """Factory of a planner with the options of its class, and with guidance.

    Args:
        make: class of the planner, whose first argument is a graph.
        weight: factor on what learned costs add to a move.
    """

    def __init__(self, make: Callable[..., Planner], weight: float = 1.0) -> None:
        self._make, self._weight = make, weight
        known = signature(make).parameters.values()
        own = [Parameter("layout", Parameter.KEYWORD_ONLY)]
        own += [Parameter("robots", Parameter.KEYWORD_ONLY, default=1)]
        own += [Parameter("guidance", Parameter.KEYWORD_ONLY, default=NONE)]
        kept = [each.replace(kind=Parameter.KEYWORD_ONLY) for each in known if each.name != "graph"]
        self.__signature__ = Signature([*kept, *own])  # which the registry reads

    def __call__(
        self, *, layout: Layout, robots: int = 1, guidance: str = NONE, **given: Any
    ) -> Planner:
        """Return a planner."""
        one_of("guidance", guidance, GUIDANCE)
        # Wrong arguments raise an error here, before the trials that learn the costs.
        self._make(Graph(layout), **given)
        costs: Costs | None = None
        if guidance == LANES:
            costs = lane_costs(layout)
        elif guidance == LEARNED:
            learned = learn(layout, robots).costs
            costs = np.round(1 + self._weight * (learned - 1), 1).astype(np.float32)
        return self._make(Graph(layout, costs_around_chargers(layout, costs)), **given)


NAMED: dict[str, Callable[..., Planner]] = {
    "pibt": Guided(PIBT),
    "windowed": Guided(WindowedPlanner, 0.5),  # half the weight reached 15.2 goals, and all 14.5
    "circulation": Guided(Circulation),
}
"""Planners for the robots of a fleet, by name."""


class Choice(NamedTuple):
    """The name of a planner with its arguments, and the reason for it."""

    name: str
    reason: str


def choose(
    layout: Layout, robots: int = 1, moves: str = COMPASS, seconds: float = STEP_SECONDS
) -> Choice:
    """Return the planner for a fleet, given its floor, robots, moves and time per step in s.

    Example:
        >>> from agents.fleet.guided import choose
        >>> from warehouse_core import shelf_layout
        >>> choose(shelf_layout(aisle=2), robots=8).name
        'windowed'
    """
    share = robots / max(len(layout.open_cells), 1)
    crowd = f"{counted(robots, 'robot')}, {share:.2f} per open cell"
    guidance, gain = NONE, ""
    if robots >= FEW_ROBOTS and SPARSE <= share <= 1:  # otherwise the fleet itself is refused
        found = learn(layout, robots).gain
        guidance = LEARNED if found >= WORTHWHILE else NONE
        gain = f"; learned costs reach {found:.2f} times as many goals in trials"
    name = "windowed"
    if share >= DENSE[moves]:
        name = "circulation"
    elif robots * ROBOT_SECONDS > seconds:
        name, crowd = "circulation", f"{crowd}, {seconds:g} s per step"
    options = f":guidance={guidance}" if guidance != NONE else ""
    return Choice(name + options, crowd + gain)


def auto(
    *, layout: Layout, robots: int = 1, moves: str = COMPASS, seed: int = 0, seconds: float = inf
) -> Planner:
    """Return the planner that ``choose`` chooses; its ``choice`` says which, and why.

    Args:
        layout: floor.
        robots: number of robots.
        moves: name of the moves of the robots.
        seed: seed of the planner.
        seconds: time per step; a planner that improves its plans does so until then.
    """
    seconds = real_number("seconds", seconds, finite=False)
    choice = choose(layout, robots, moves, min(seconds, STEP_SECONDS))
    name, _, guidance = choice.name.partition(":guidance=")
    given: dict[str, Any] = {"seconds": seconds} if name == "windowed" else {}
    given |= {"layout": layout, "robots": robots, "seed": seed, "guidance": guidance or NONE}
    planner = NAMED[name](**given)
    planner.choice = choice  # type: ignore[attr-defined]
    return planner
