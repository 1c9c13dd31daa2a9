"""Diagnosis of the failure mode of an episode: the pattern that a viewer of its replay would see.

``diagnose`` returns the first mode of the table that applies; at least one always does. Most modes
exist either for the record of a single robot or for the record of a fleet. The last column says
which steps ``Diagnosis.steps`` counts.

| mode             | who   | applies when                                          | ``steps``     |
| ---------------- | ----- | ----------------------------------------------------- | ------------- |
| delivered        | robot | the item was delivered                                | all           |
| unreachable      | robot | no path leads to a pickup and then to a dropoff or,   | all           |
|                  |       | once the item is picked up, to a dropoff              |               |
|                  | fleet | no path leads from a robot to the pickup or dropoff   | all           |
|                  |       | of its order, or from any robot to an unassigned      |               |
|                  |       | order                                                 |               |
| stalled          | robot | in ``CAUSE_SHARE`` of the lost steps the robot did    | these steps   |
|                  |       | not reach its target cell although nothing blocked it |               |
|                  |       | (it stayed, or slid to another cell)                  |               |
| ineffective      | robot | ``LOST_SHARE`` of the lost steps had no effect:       | these steps   |
|                  |       | unknown actions, useless picks or drops, waits, or    |               |
|                  |       | bumps                                                 |               |
| oscillation      | robot | for ``CAUSE_SHARE`` of the lost steps, up to the end, | at the end    |
|                  |       | it stayed in one cell, moved back and forth between   |               |
|                  |       | up to ``MAX_SWING_CELLS`` cells, or repeated one loop |               |
|                  |       | of any size at least ``ROUNDS`` times                 |               |
| wandering        | robot | ``LOST_SHARE`` of its moves from cell to cell were    | lost moves    |
|                  |       | lost                                                  |               |
| battery depleted | robot | none of the above, and the battery ran out            | still needed  |
| out of time      | robot | none of the above, and the step limit was reached     | still needed  |
| unfinished       | robot | none of the above, and the episode was stopped early  | still needed  |
| no charger       | fleet | a robot with orders or chargers ran out of battery,   | all           |
|                  |       | and no charger was in reach of a full battery         |               |
| oversubscribed   | fleet | a robot ran out of battery, and the chargers supply   | all           |
|                  |       | less than the robots use, or were in use in           |               |
|                  |       | ``BUSY_SHARE`` of the steps                           |               |
| flat in the way  | fleet | a robot with a flat battery blocked moves of others,  | blocked moves |
|                  |       | or a queue as in a deadlock                           | or at the end |
| stranded         | fleet | a robot ran out of battery, or failed permanently     | 0             |
| deadlock         | fleet | during the last ``MIN_STANDING`` steps or more,       | at the end    |
|                  |       | robots did not leave their cells, and each was        |               |
|                  |       | blocked by the next one in ``STOPPED_SHARE`` of these |               |
|                  |       | steps: in a ring, or in a queue behind a robot that   |               |
|                  |       | does not move                                         |               |
| people           | fleet | robots formed such a queue behind a person, or        | at the end or |
|                  |       | people blocked ``BLOCKED_SHARE`` of the moves         | blocked moves |
| too many orders  | fleet | the robots were busy, and more than ``FEW_WAITING``   | all           |
|                  |       | orders per robot waited at the end                    |               |
| overtaken order  | fleet | an order that missed its deadline waited while        | of the wait   |
|                  |       | ``MIN_OVERTAKING`` orders that were released after it |               |
|                  |       | were picked up                                        |               |
| congested        | fleet | ``BLOCKED_SHARE`` of the moves were blocked by robots | blocked moves |
|                  |       | or people                                             |               |
| idle             | fleet | in ``IDLE_SHARE`` of all steps of all robots a robot  | waits         |
|                  |       | waited, and not on a charger                          |               |
| late             | fleet | more than ``LATE_SHARE`` of the deliveries were late  | all           |
| served           | fleet | none of the above                                     | all           |

*Needed* is the minimum number of steps to the delivery, including ``PICK`` and ``DROP``. *Lost*
steps brought the robot no closer to the delivery. Their number is the number of all steps minus the
decrease in needed steps from start to end. Fewer than ``MIN_STEPS`` steps are never evidence.
Waiting and running into walls do not change a pattern, because a visit to a cell may have any
length. Steps in which the battery charged are not lost and do not count in any pattern.

A fleet that has delivered everything is either late or served.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from functools import cached_property
from itertools import pairwise
from operator import ne
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from warehouse_core.arguments import instance_of
from warehouse_core.motion.base import NOTHING
from warehouse_core.orders.order import OrderQueue
from warehouse_core.records.episode import (
    BATTERY_DEPLETED,
    DELIVERED,
    OUT_OF_TIME,
    UNFINISHED,
    Episode,
)
from warehouse_core.wording import brief, counted, listed
from warehouse_core.world.actions import DISPLACEMENTS, DROP, INVALID, PICK, WAIT, action_index
from warehouse_core.world.distances import distances
from warehouse_core.world.layout import Layout
from warehouse_core.world.tiles import WALL, Cell, moved

UNREACHABLE, STALLED, INEFFECTIVE = "unreachable", "stalled", "ineffective"
OSCILLATION, WANDERING = "oscillation", "wandering"
NO_CHARGER, OVERSUBSCRIBED = "no charger", "oversubscribed"
FLAT_IN_THE_WAY, STRANDED = "flat in the way", "stranded"
DEADLOCK, PEOPLE = "deadlock", "people"
TOO_MANY_ORDERS, OVERTAKEN = "too many orders", "overtaken order"
CONGESTED, IDLE, LATE, SERVED = "congested", "idle", "late", "served"

CAUSE_SHARE = 0.4
"""Share of the lost steps that one cause explains; less than half, because a robot may get stuck
more than once."""

LOST_SHARE = 0.5
"""Share of the moves, or of the lost steps. A path of twice the optimal length loses half."""

MAX_SWING_CELLS = 4
"""Most cells of a swing: the cell where the robot is stuck and up to three neighbours."""

MIN_STEPS = 2 * MAX_SWING_CELLS
"""Fewest steps that are evidence: two visits to each of ``MAX_SWING_CELLS`` cells."""

ROUNDS = 3
"""Repetitions of the same cells in the same order that count as a loop."""

MIN_STANDING = 10
"""Steps in one cell at the end that count as a deadlock; fewer may be a short stop."""

STOPPED_SHARE = 0.5
"""Share of these steps in which the same robot has to be in the way."""

MIN_OVERTAKING = 10
"""Later orders picked up first; fewer may just be closer to a robot."""

FEW_WAITING = 2
"""Orders per robot that may wait; more keep arriving faster than the fleet delivers."""

BUSY_SHARE = 0.8
"""Share of the steps with a robot that charges above which a charger is busy. Robots take the rest
to leave it and to come to it."""

BLOCKED_SHARE, IDLE_SHARE, LATE_SHARE = 0.25, 0.5, 0.5
"""Shares of the moves, of the steps of all robots, and of the deliveries, respectively."""

NO_MOVES = {INVALID: "unknown action", PICK: "useless pick", DROP: "useless drop", WAIT: "wait"}
"""Names of the actions that do not move a robot, by index, in the order in which they are
checked."""

BUMP = "bump"
"""Name of a blocked move; it is checked last."""

ENDINGS = {
    BATTERY_DEPLETED: "the battery ran out",
    OUT_OF_TIME: "the time ran out",
    UNFINISHED: "the episode was stopped",
}

CellState = tuple[Cell, bool]
"""The cell of the robot, and whether it holds an item."""


class Diagnosis(NamedTuple):
    """The failure mode of an episode, with the evidence.

    Attributes:
        mode: One of ``MODES``, or of ``FLEET_MODES``.
        cells: Cells of the evidence. ``oscillation``: cells of the pattern, in the order of the
            visits. ``unreachable``: stations that cannot be reached, if there are any.
            ``stalled``: the cell where most of the steps failed. ``congested`` and
            ``people``: the cell where most moves were blocked. ``overtaken order``: the pickup of
            the order. Other modes: the last cells of the robots.
        steps: Number of steps of the evidence; the table at the top of this file says which.
        needed: Minimum number of steps from the start to the delivery; ``None`` without a path and
            for fleets.
        sentence: The evidence in words.
        robots: Numbers of the robots involved, in ascending order. ``deadlock``: the robots of the
            queue or ring, in its order. ``overtaken order``: the robot that picked it up, if any.

    Example:
        >>> from agents import GreedyAgent
        >>> from warehouse_core import WarehouseEnv, record_episode
        >>> from warehouse_core.records import diagnose
        >>> agent = GreedyAgent(seed=1, escape_steps=0)
        >>> diagnosis = diagnose(record_episode(WarehouseEnv(), agent, seed=1))
        >>> diagnosis.mode, diagnosis.needed
        ('oscillation', 17)
        >>> diagnosis.sentence
        'kept moving between (1, 5), (2, 5), (3, 5) and (2, 6) for the last 200 steps'
    """

    mode: str
    cells: tuple[Cell, ...]
    steps: int
    needed: int | None
    sentence: str
    robots: tuple[int, ...] = (0,)


class Evidence(NamedTuple):
    """The evidence that a rule of ``TABLE`` finds in an episode; fields as in ``Diagnosis``."""

    sentence: str
    cells: Sequence[Cell]
    steps: int
    robots: Sequence[int] = (0,)


Rule = Callable[[Any], Evidence | None]
"""Function that returns the evidence for a mode, or ``None`` if the mode does not apply."""


class Alone:
    """The episode of a single robot, with the quantities that the rules use.

    Attributes:
        needed: Minimum number of steps from the start to the delivery; ``None`` without a path.
        left: Minimum number of steps from the ``end`` to the delivery; ``None`` without a path.
            The ``end`` is the last cell and load of the robot.
        nearer: Number of steps by which the robot has come closer to the delivery.
    """

    def __init__(self, episode: Episode) -> None:
        start, self.end = ((episode.cells[at], episode.loaded[at]) for at in (0, -1))
        self.episode = episode
        self.needed, self.left = needed, left = fewest_steps(episode.layout, start, self.end)
        self.nearer = 0 if needed is None or left is None else max(needed - left, 0)

    @cached_property
    def charging(self) -> set[int]:
        """Numbers of the steps in which the battery level rose."""
        return {step for step, (a, b) in enumerate(pairwise(self.episode.battery)) if b > a}

    @cached_property
    def lost(self) -> int:
        """Number of lost steps."""
        return self.episode.steps - len(self.charging) - self.nearer

    @cached_property
    def missed(self) -> list[Cell]:
        """Start cell of each step that missed its target cell although nothing blocked it."""
        episode = self.episode
        deltas = {action: DISPLACEMENTS[action_index(action)] for action in set(episode.actions)}
        moves = zip(episode.cells, episode.actions, episode.motions, strict=False)
        return [
            cell
            for cell, action, motion in moves
            if motion.cell != moved(cell, deltas[action]) and not motion.blocked
        ]

    def least(self, share: float) -> float:
        """Return the minimum number of steps that counts as evidence: a share of the lost steps.

        It is infinite if too few steps were lost.
        """
        return max(MIN_STEPS, share * self.lost) if self.lost >= MIN_STEPS else math.inf

    @property
    def misses(self) -> str:
        """End of a sentence that mentions the steps in ``missed`` and an action never used."""
        missed = f"; {_count(len(self.missed))} missed their target cell" if self.missed else ""
        return missed + self._unused

    @property
    def _unused(self) -> str:
        episode, loaded = self.episode, self.end[1]
        stations = episode.layout.dropoffs if loaded else episode.layout.pickups
        action, name, kind = (DROP, "DROP", "dropoff") if loaded else (PICK, "PICK", "pickup")
        cells = [None, *(cell for cell, load in zip(episode.cells, episode.loaded, strict=True)
                         if load == loaded)]  # fmt: skip
        visits = sum(cell in stations and cell != before for before, cell in pairwise(cells))
        if not visits or action in map(action_index, episode.actions):
            return ""
        return f"; never used {name}: it stood on the {kind} {counted(visits, 'time')}"


def diagnose(episode: Episode) -> Diagnosis:
    """Return the failure mode of an episode. It depends only on the record, not on the agent.

    Example:
        >>> from agents import GreedyAgent
        >>> from warehouse_core import WarehouseEnv, record_episode
        >>> from warehouse_core.records import diagnose
        >>> diagnose(record_episode(WarehouseEnv(), GreedyAgent(seed=12), seed=12)).mode
        'delivered'
    """
    instance_of("episode", episode, Episode)
    alone = None if episode.is_fleet else Alone(episode)
    needed = None if alone is None else alone.needed
    is_done = episode.is_fleet and episode.terminated.all()
    # The other rules count moves from cell to cell.
    known = DRIVEN_MODES if episode.is_driven else [mode for mode, *_ in TABLE]
    results = (
        (mode, rule(alone or episode))
        for mode, *rules in TABLE
        if mode in known
        and (rule := rules[episode.is_fleet])
        and (mode in (LATE, SERVED) or not is_done)
    )
    mode, evidence = next((mode, evidence) for mode, evidence in results if evidence)
    sentence, cells, steps, robots = evidence
    return Diagnosis(mode, tuple(cells), steps, needed, sentence, tuple(robots))


def _delivered(alone: Alone) -> Evidence | None:
    if not alone.episode.terminated:
        return None
    steps = alone.episode.steps
    taken = f"{_count(steps)}{_shortest(alone)}"
    if alone.episode.is_driven:
        taken = f"{alone.episode.seconds:.1f} s"
    return Evidence(f"delivered in {taken}", alone.end[:1], steps)


def _cut_off(alone: Alone) -> Evidence | None:
    """Find the stations that cannot be reached."""
    if alone.left is not None:
        return None
    (here, loaded), layout = alone.end, alone.episode.layout
    if loaded or not layout.reachable_from(here).isdisjoint(layout.pickups):
        name, stations = "dropoff", layout.dropoffs
    else:
        name, stations = "pickup", layout.pickups
    sentence = f"there is no {name}"
    if stations:
        sentence = f"no path leads from {here} to the {name} at {listed(stations, 'or')}"
    return Evidence(sentence, stations, alone.episode.steps)


def _stalled(alone: Alone) -> Evidence | None:
    misses = len(alone.missed)
    if misses < alone.least(CAUSE_SHARE):
        return None
    [(worst, times)] = Counter(alone.missed).most_common(1)
    sentence = (
        f"{misses} of {_count(alone.episode.steps)} missed their target cell although nothing "
        f"blocked them, {times} of them from {worst}"
    )
    return Evidence(sentence, (worst,), misses)


def _ineffective(alone: Alone) -> Evidence | None:
    """Count the steps without effect. If a single kind is enough evidence, count only this kind."""
    episode, least = alone.episode, alone.least(LOST_SHARE)
    details: dict[str, Counter[str]] = {kind: Counter() for kind in (*NO_MOVES.values(), BUMP)}
    states = list(zip(episode.cells, episode.loaded, strict=True))
    for step, (action, motion, before, after) in enumerate(
        zip(episode.actions, episode.motions, states, states[1:], strict=False)
    ):
        index = action_index(action)
        if before == after and step not in alone.charging and (index in NO_MOVES or motion.blocked):
            detail = brief(action) if index == INVALID else f"at {before[0]}"
            details[NO_MOVES.get(index, BUMP)][detail] += 1
    enough = [kind for kind, each in details.items() if each.total() >= least][:1]
    kinds = enough or [kind for kind, each in details.items() if each]
    steps = sum(details[kind].total() for kind in kinds)
    if steps < least:
        return None
    sentence = listed(counted(details[kind].total(), kind) for kind in kinds)
    if len(kinds) == 1:
        [(detail, times)] = details[kinds[0]].most_common(1)
        sentence += f": {detail}" if times == steps else f", {times} of them {detail}"
    return Evidence(sentence, alone.end[:1], steps)


def _oscillation(alone: Alone) -> Evidence | None:
    cells, loaded = alone.episode.cells, alone.episode.loaded
    first = loaded.index(loaded[-1])
    leg = [cell for step, cell in enumerate(cells[first:], first) if step - 1 not in alone.charging]
    swing, steps = _find_swing(leg, alone.least(CAUSE_SHARE))
    if not swing:
        return None
    sentence = f"{_describe(swing)} for the last {_count(steps)}{alone.misses}"
    return Evidence(sentence, swing, steps)


def _wandering(alone: Alone) -> Evidence | None:
    cells, nearer = alone.episode.cells, alone.nearer
    moves = sum(map(ne, cells, cells[1:]))
    if alone.lost < MIN_STEPS or moves - nearer < max(MIN_STEPS, LOST_SHARE * moves):
        return None
    sentence = f"{moves} moves over {len(set(cells))} cells "
    sentence += f"brought it only {_count(nearer)} closer" if nearer else "without getting closer"
    return Evidence(f"{sentence} to the delivery{alone.misses}", alone.end[:1], moves - nearer)


def _out_of(ending: str) -> Callable[[Alone], Evidence | None]:
    """Return the rule of the mode for an ending of an episode."""

    def find(alone: Alone) -> Evidence | None:
        if alone.episode.outcome != ending or alone.left is None:
            return None
        short = f"{ENDINGS[ending]} {_count(alone.left)} short of the delivery"
        return Evidence(f"{short}{_shortest(alone)}", alone.end[:1], alone.left)

    return find


def _shortest(alone: Alone) -> str:
    return "" if alone.needed is None else f"; the minimum is {alone.needed}"


def fewest_steps(layout: Layout, *states: CellState) -> tuple[int | None, ...]:
    """Return the minimum number of steps from each state to the delivery, ``None`` without a path.

    A breadth-first search runs backwards from the dropoffs, with the item. When it reaches a
    pickup, it also continues from there without the item.
    """
    stride = layout.width + 1
    edge = WALL * stride
    floor = edge + "".join([row + WALL for row in layout.rows]) + edge
    unloaded = len(floor)  # the number of a state without the item minus the number with it
    fresh = bytearray((floor * 2).replace(WALL, "\0"), "ascii")

    def number(cell: Cell) -> int:
        return (cell[0] + 1) * stride + cell[1]

    sought = [number(cell) + (0 if loaded else unloaded) for cell, loaded in states]
    steps_from: dict[int, int | None] = dict.fromkeys(sought)
    pickups, frontier = set(map(number, layout.pickups)), list(map(number, layout.dropoffs))
    steps = 0
    while frontier and None in steps_from.values():
        steps += 1
        ahead: list[int] = []
        for here in frontier:
            if fresh[here]:
                fresh[here] = 0
                ahead += (here - stride, here + 1, here + stride, here - 1)
                if here in pickups:
                    ahead.append(here + unloaded)
        for state in sought:
            if steps_from[state] is None and not fresh[state]:
                steps_from[state] = steps
        frontier = ahead
    return tuple(steps_from[state] for state in sought)


def _find_swing(leg: Sequence[Cell], least: float) -> tuple[tuple[Cell, ...], int]:
    """Return the smallest set of cells that the robot did not leave at the end, and how long.

    Args:
        leg: Cells of the robot, step by step, either all with the item or all without it.
        least: Fewest steps that count. If there are fewer, the result is ``((), 0)``.
    """
    arrivals = [step for step, cell in enumerate(leg) if step == 0 or cell != leg[step - 1]]
    path = [leg[step] for step in arrivals]
    # After the last visit to a cell, the robot visited only cells whose last visits are later.
    last_visits = sorted({cell: visit for visit, cell in enumerate(path)}.values(), reverse=True)
    for begin in [visit + 1 for visit in [*last_visits[1:], -1][:MAX_SWING_CELLS]]:
        steps = len(leg) - 1 - arrivals[begin]
        if steps >= least and (begin == len(path) - 1 or path[begin] in path[begin + 1 :]):
            return tuple(dict.fromkeys(path[begin:])), steps
    begin = _loop_begin(path)
    steps = len(leg) - 1 - arrivals[begin]
    return (tuple(dict.fromkeys(path[begin:])), steps) if steps >= least else ((), 0)


def _loop_begin(path: Sequence[Cell]) -> int:
    """Return the visit from which on a path repeats one loop at least ``ROUNDS`` times.

    Without a loop this is the last visit. The function computes the failure function of Knuth,
    Morris and Pratt for the reversed path: its first ``k`` visits begin and end with the same
    ``border[k]`` visits, so they repeat with the period ``k - border[k]``.
    """
    back, border, longest = path[::-1], [0, 0], 1
    for k, cell in enumerate(back[1:], start=2):
        shared = border[-1]
        while shared and back[shared] != cell:
            shared = border[shared]
        shared += back[shared] == cell
        border.append(shared)
        if k >= ROUNDS * (k - shared):
            longest = k
    return len(path) - longest


def _describe(swing: Sequence[Cell]) -> str:
    if len(swing) == 1:
        return f"stayed in {swing[0]}"
    if len(swing) <= MAX_SWING_CELLS:
        return f"kept moving between {listed(swing)}"
    return f"repeated a loop of {len(swing)} cells through {swing[0]}"


def _count(steps: int) -> str:
    return counted(steps, "step")


def _no_path(episode: Episode) -> Evidence | None:
    """Find the first undelivered order whose next station its robots cannot reach."""
    cells = _ends(episode)
    left = {number: each for number, each in enumerate(episode.orders) if each.delivered is None}
    for number, order in left.items():
        sent = order.robot if order.taken is None else order.taken_by
        robots = range(episode.robots) if sent is None else [sent]
        goal, name = (order.pickup, "pickup") if order.taken is None else (order.dropoff, "dropoff")
        reached = episode.layout.reachable_from(goal)
        if reached.isdisjoint(cells[robot] for robot in robots):
            who = _named(robots, cells) if len(robots) == 1 else "any robot"
            sentence = f"no path leads from {who} to the {name} of order {number} at {goal}"
            return Evidence(sentence, (goal,), episode.steps, robots)
    return None


def _flat(episode: Episode) -> list[int]:
    """Return the robots that ran out of battery."""
    return np.flatnonzero(episode.battery[-1] <= 0).tolist()


def _without_charger(episode: Episode) -> Evidence | None:
    battery = episode.settings.battery
    if episode.settings.orders is None and not episode.layout.chargers:
        return None  # in the chapter's task, a flat battery simply ends the episode
    reach = battery.capacity / battery.step_cost(episode.cell_size)
    steps = distances(episode.layout, episode.layout.chargers).ravel()[episode.cells[-1]]
    robots = [robot for robot in _flat(episode) if steps[robot] > reach]
    sentence = f"; no charger is within the {reach:.0f} steps that a full battery lasts"
    return _ran_out(episode, robots, sentence, episode.steps) if robots else None


def _ran_out(episode: Episode, robots: Sequence[int], end: str, steps: int) -> Evidence:
    """Return the evidence that robots ran out of battery, with the end of the sentence."""
    cells = _ends(episode)
    sentence = f"{_named(robots, cells)} ran out of battery{end}"
    return Evidence(sentence, [cells[robot] for robot in robots], steps, robots)


def _oversubscribed(episode: Episode) -> Evidence | None:
    robots, (supply, share, use) = _flat(episode), _charger_use(episode)
    if not robots or not use or not (supply < 1 or share >= BUSY_SHARE):
        return None
    return _ran_out(episode, robots, use, episode.steps)


def _charger_use(episode: Episode) -> tuple[float, float, str]:
    """Return the supply of chargers, the share of steps that they are in use, and both in words.

    The supply is a share of what the robots use. The words end a sentence; without chargers there
    are none.
    """
    battery, chargers = episode.settings.battery, len(episode.layout.chargers)
    if not chargers:
        return 0.0, 0.0, ""
    drain = episode.robots * battery.step_cost(episode.cell_size)
    supply = chargers * battery.step_charge(episode.cell_size) / drain
    share = episode.measures.charging / (chargers * max(episode.steps, 1))
    words = (
        f"; {counted(chargers, 'charger')}, in use in {share:.0%} of the steps, can supply "
        f"{supply:.2f} times what {counted(episode.robots, 'robot')} use"
    )
    return supply, share, words


def _flat_in_the_way(episode: Episode) -> Evidence | None:
    robots, cells = _flat(episode), _ends(episode)
    if not robots:
        return None
    blocked = int(np.isin(episode.stopped_by, robots).sum())
    queue = _longest(episode, robots)
    if not blocked and not queue:
        return None
    if not queue:
        sentence = f" and blocked {counted(blocked, 'move')} of other robots{_supply(episode)}"
        return _ran_out(episode, robots, sentence, blocked)
    sentence = (
        f"{_named(robots, cells)} ran out of battery and blocked {_named(queue.robots[:-1], cells)}"
        f" for the last {_count(queue.steps)}{_supply(episode)}"
    )
    return Evidence(sentence, [cells[each] for each in queue.robots], queue.steps, queue.robots)


def _supply(episode: Episode) -> str:
    """Return the end of a sentence about flat batteries: the chargers, and the lost orders."""
    return _charger_use(episode)[-1] + _lost(episode)


def _lost(episode: Episode) -> str:
    lost = episode.measures.lost
    return f"; {counted(lost, 'order')} can no longer be delivered" if lost else ""


def _stranded(episode: Episode) -> Evidence | None:
    robots, failed = _flat(episode), episode.measures.stranded
    if not robots:
        # A record has the battery level of each robot, but of failures only their number.
        sentence = f"{counted(failed, 'robot')} failed permanently{_lost(episode)}"
        return Evidence(sentence, (), 0, ()) if failed else None
    return _ran_out(episode, robots, _supply(episode), 0)


def _deadlock(episode: Episode) -> Evidence | None:
    """Find robots that block each other in a ring, or the longest queue behind a standing robot."""
    found, cells = _longest(episode, range(episode.robots)), _ends(episode)
    if not found:
        return None
    longest, since, is_ring, behind = found
    if is_ring:
        what = f"{_named(longest, cells)} blocked each other"
    else:
        what = f"{_blocked(longest, cells)} {_named(longest[-1:], cells)}, which stayed,"
    more = f"; waiting behind them: {_named(behind, cells)}" if behind else ""
    sentence = f"{what} for the last {_count(since)}{more}"
    return Evidence(sentence, [cells[robot] for robot in longest], since, longest)


def _blocked(queue: Sequence[int], cells: Sequence[Cell]) -> str:
    """Return the beginning of a sentence: all in a queue but the first were blocked by it."""
    *waiting, _ = queue
    return f"{_named(waiting, cells)} {'were' if len(waiting) > 1 else 'was'} blocked by"


class Jam(NamedTuple):
    """Bodies of which each blocks the one before it, and for how many steps at the end.

    If they are a ring, ``behind`` are the robots that wait behind it.
    """

    robots: list[int]
    steps: int
    is_ring: bool
    behind: list[int]


def _longest(episode: Episode, first: Sequence[int]) -> Jam | None:
    """Return the longest ring, or else the longest queue behind one of the bodies ``first``."""
    steps, ahead = _standing(episode)
    queues = {robot: _queue(robot, ahead) for robot in ahead}
    rings = [queue for queue in queues.values() if ahead.get(queue[-1]) == queue[0]]
    rings = [queue for queue in rings if queue[0] in first]
    charges = {*np.flatnonzero(episode.battery[-1] > episode.battery[-2:][0]).tolist()}
    stays = {robot for robot, each in enumerate(steps) if each >= MIN_STANDING} - charges
    stays.update(range(episode.robots, episode.settings.bodies))
    stuck = [queue for queue in queues.values() if queue[-1] in stays.intersection(first)]
    longest = max(rings or stuck, key=len, default=[])
    if not longest:
        return None
    since = min(steps[robot] for robot in longest if robot < episode.robots)
    behind = [robot for robot in ahead if queues[robot] == longest and robot not in longest]
    return Jam(longest, since, bool(rings), behind if rings else [])


def _standing(episode: Episode) -> tuple[list[int], dict[int, int]]:
    """Return how many steps each robot has stayed in its last cell, and which body blocks it.

    A robot that waits is blocked by the body in the next cell on a shortest path to its goal.
    """
    steps: list[int] = []
    ahead: dict[int, int] = {}
    goals, people = _goals(episode), episode.people
    bodies = np.hstack([episode.cells, people]) if len(people) else episode.cells
    for robot, path in enumerate(episode.cells.T):
        changes = np.flatnonzero(path != path[-1])
        steps.append(len(path) - 2 - int(changes[-1]) if len(changes) else len(path) - 1)
        if steps[-1] < MIN_STANDING or episode.battery[-1, robot] <= 0:
            continue
        since = len(episode.stopped_by) - steps[-1]
        stops = episode.stopped_by[since:, robot]
        if robot in goals:
            in_way = np.isin(bodies[since:-1], _next_cells(episode.layout, path[-1], goals[robot]))
            waits = (stops == NOTHING) & in_way.any(axis=1)
            stops = np.where(waits, in_way.argmax(axis=1), stops)
        [(by, times)] = Counter(stops.tolist()).most_common(1)
        if by >= 0 and times >= STOPPED_SHARE * steps[-1]:
            ahead[robot] = by
    return steps, ahead


def _goals(episode: Episode) -> dict[int, Cell]:
    """Return the cells where robots have to pick or drop next, by robot."""
    orders, assigned = episode.orders, {robot: each for _, robot, each in episode.assignments}
    open_orders = {robot: orders[each] for robot, each in assigned.items() if each is not None}
    goals = {robot: each.pickup for robot, each in open_orders.items() if each.taken is None}
    carried = [each for each in orders if each.taken is not None and each.delivered is None]
    return goals | {each.taken_by: each.dropoff for each in carried if each.taken_by is not None}


def _next_cells(layout: Layout, cell: int, goal: Cell) -> list[int]:
    """Return the cells that follow a cell on its shortest paths to a goal."""
    field, here = distances(layout, [goal]), layout.cell(cell)
    near = [moved(here, DISPLACEMENTS[move]) for move in range(WAIT)]
    near = [each for each in near if layout.is_open(each) and field[each] < field[here]]
    return [layout.number(each) for each in near]


def _queue(robot: int, ahead: dict[int, int]) -> list[int]:
    """Return the robot, the robot that blocks it, and so on, or the ring in which this ends."""
    queue = [robot]
    while queue[-1] in ahead:
        following = ahead[queue[-1]]
        if following in queue:
            ring = queue[queue.index(following) :]
            first = ring.index(min(ring))
            return ring[first:] + ring[:first]
        queue.append(following)
    return queue


def _people(episode: Episode) -> Evidence | None:
    """Find a queue behind a person, or the cell where people blocked most moves."""
    count, cells = episode.robots, _ends(episode)
    queue = _longest(episode, range(count, episode.settings.bodies))
    if queue:
        robots = queue.robots[:-1]
        cell = episode.layout.cell(episode.people[-1][queue.robots[-1] - count])
        sentence = (
            f"{_blocked(queue.robots, cells)} a person, at {cell} in the end, for the last "
            f"{_count(queue.steps)}"
        )
        return Evidence(sentence, (cell,), queue.steps, robots)
    return _jammed(episode, episode.stopped_by >= count, "people")


def _too_many_orders(episode: Episode) -> Evidence | None:
    measures, robots = episode.measures, episode.robots
    waiting = sum(order.taken is None for order in episode.orders)
    is_queue = isinstance(episode.settings.orders, OrderQueue)  # which is full at all times
    if is_queue or waiting <= FEW_WAITING * robots or _idle(episode):
        return None
    sentence = (
        f"{counted(measures.orders, 'order')} came in {_count(episode.steps)}, and "
        f"{counted(robots, 'robot')} delivered {measures.delivered}; {waiting} wait for a robot"
    )
    return _of_all(episode, sentence, episode.steps)


def _overtaken(episode: Episode) -> Evidence | None:
    """Check whether later orders overtook the late order that waited longest."""
    steps = episode.steps
    waits = {
        number: (steps if order.taken is None else order.taken) - order.released
        for number, order in enumerate(episode.orders)
        if (steps if order.delivered is None else order.delivered) > order.due
    }
    if not waits:
        return None
    worst = max(waits, key=waits.__getitem__)
    order, end = episode.orders[worst], episode.orders[worst].released + waits[worst]
    overtaking = sum(
        other.released > order.released and other.taken is not None and other.taken < end
        for other in episode.orders
    )
    if overtaking < MIN_OVERTAKING:
        return None
    sentence = (
        f"order {worst} at {order.pickup}, due at step {order.due}, waited for "
        f"{_count(waits[worst])} while {overtaking} orders released after it were picked up"
    )
    robots = () if order.taken_by is None else (order.taken_by,)
    return Evidence(sentence, (order.pickup,), waits[worst], robots)


def _congested(episode: Episode) -> Evidence | None:
    return _jammed(episode, episode.stopped_by >= 0, "robots or people")


def _jammed(episode: Episode, stopped: NDArray[np.bool_], by: str) -> Evidence | None:
    """Return evidence if enough moves were ``stopped``, ``[T, R]``, with the worst cell."""
    moves, blocked = int((episode.counted_actions() < WAIT).sum()), int(stopped.sum())
    if not blocked or blocked < BLOCKED_SHARE * moves:
        return None
    [(worst, times)] = Counter(episode.cells[:-1][stopped].tolist()).most_common(1)
    cell = episode.layout.cell(worst)
    sentence = (
        f"{blocked} of {counted(moves, 'move')} were blocked by {by}; the worst cell is {cell}, "
        f"with {times}"
    )
    return Evidence(sentence, (cell,), blocked, range(episode.robots))


def _idle(episode: Episode) -> Evidence | None:
    measures = episode.measures
    steps = measures.steps * episode.robots
    if not measures.waits or measures.waits < IDLE_SHARE * steps:
        return None
    sentence = (
        f"the robots waited in {measures.waits:,} of {_count(steps)}, with "
        f"{counted(measures.orders, 'order')} for {counted(episode.robots, 'robot')}"
    )
    return _of_all(episode, sentence, measures.waits)


def _late(episode: Episode) -> Evidence | None:
    measures = episode.measures
    if not measures.on_time < 1 - LATE_SHARE:
        return None
    late = round((1 - measures.on_time) * measures.delivered)
    sentence = (
        f"{late} of {measures.delivered} deliveries were late; the mean lateness of all "
        f"deliveries is {_count(round(measures.mean_lateness))}"
    )
    return _of_all(episode, sentence, episode.steps)


def _served(episode: Episode) -> Evidence:
    return _of_all(episode, f"{episode.outcome} in {_count(episode.steps)}", episode.steps)


def _of_all(episode: Episode, sentence: str, steps: int) -> Evidence:
    """Return the evidence for a mode that involves all robots, with their last cells."""
    return Evidence(sentence, _ends(episode), steps, range(episode.robots))


def _ends(episode: Episode) -> list[Cell]:
    """Return the last cells of the robots."""
    return episode.layout.cells(episode.cells[-1])


def _named(robots: Sequence[int], cells: Sequence[Cell]) -> str:
    """Return the robots and their cells in words."""
    return listed(f"robot {robot} at {cells[robot]}" for robot in robots)


TABLE: tuple[tuple[str, Rule | None, Rule | None], ...] = (
    (DELIVERED, _delivered, None),
    (UNREACHABLE, _cut_off, _no_path),
    (STALLED, _stalled, None),
    (INEFFECTIVE, _ineffective, None),
    (OSCILLATION, _oscillation, None),
    (WANDERING, _wandering, None),
    *((ending, _out_of(ending), None) for ending in ENDINGS),
    (NO_CHARGER, None, _without_charger),
    (OVERSUBSCRIBED, None, _oversubscribed),
    (FLAT_IN_THE_WAY, None, _flat_in_the_way),
    (STRANDED, None, _stranded),
    (DEADLOCK, None, _deadlock),
    (PEOPLE, None, _people),
    (TOO_MANY_ORDERS, None, _too_many_orders),
    (OVERTAKEN, None, _overtaken),
    (CONGESTED, None, _congested),
    (IDLE, None, _idle),
    (LATE, None, _late),
    (SERVED, None, _served),
)
"""Each mode, its rule for ``Alone``, and its rule for the record of a fleet, in the order in which
they are checked. ``None`` means that the mode does not exist for this kind of record."""

DRIVEN_MODES = (DELIVERED, UNREACHABLE, *ENDINGS)
"""Modes of a robot that is controlled continuously."""

MODES = tuple(mode for mode, alone, _ in TABLE if alone)
"""Modes of a single robot."""

FLEET_MODES = tuple(mode for mode, _, fleet in TABLE if fleet)
"""Modes of a fleet."""
