"""The failure mode of an episode: the pattern that a viewer of its replay would name.

``diagnose`` returns the first mode that applies; one always does. Most modes are for the record of
a lone robot or for the record of a fleet only.

| mode             | who   | applies when                                          | ``steps``     |
| ---------------- | ----- | ----------------------------------------------------- | ------------- |
| delivered        | robot | the item was delivered                                | all           |
| unreachable      | robot | no path leads to a pickup and then to a dropoff, or,  | all           |
|                  |       | with the item picked up, to a dropoff                 |               |
|                  | fleet | no way leads from a robot to the pickup of the order  | all           |
|                  |       | that waits for it or to where its item is due; or     |               |
|                  |       | from any robot to an open order                       |               |
| stalled          | robot | ``CAUSE_SHARE`` of the lost steps missed their cell:  | that missed   |
|                  |       | with nothing in its way the robot stayed, or slid to  |               |
|                  |       | another cell                                          |               |
| ineffective      | robot | ``LOST_SHARE`` of the lost steps had no effect:       | no effect     |
|                  |       | unknown actions, useless picks or drops, waits, or    |               |
|                  |       | bumps                                                 |               |
| oscillation      | robot | for ``CAUSE_SHARE`` of the lost steps up to the end   | at the end    |
|                  |       | it stayed on one cell, swung between up to            |               |
|                  |       | ``MAX_SWING_CELLS``, or repeated one loop of any size |               |
|                  |       | ``ROUNDS`` times                                      |               |
| wandering        | robot | ``LOST_SHARE`` of its moves from cell to cell were    | lost moves    |
|                  |       | lost                                                  |               |
| battery depleted | robot | none of these, and the battery ran out                | still needed  |
| out of time      | robot | none of these, and the steps ran out                  | still needed  |
| unfinished       | robot | none of these, and the driver of the robot stopped    | still needed  |
| stranded         | fleet | the battery of a robot ran out, or a robot failed for | others' moves |
|                  |       | good                                                  |               |
| deadlock         | fleet | for ``MIN_STANDING`` steps up to the end robots did   | at the end    |
|                  |       | not leave their cells, each stopped by the next one   |               |
|                  |       | in ``STOPPED_SHARE`` of these steps: in a ring, or in |               |
|                  |       | a queue behind one that stays                         |               |
| starvation       | fleet | an order that was not delivered when it was due       | of the wait   |
|                  |       | waited while ``MIN_OVERTAKING`` orders that were      |               |
|                  |       | released after it were taken                          |               |
| congested        | fleet | ``BLOCKED_SHARE`` of the moves were stopped by robots | stopped moves |
|                  |       | or people                                             |               |
| idle             | fleet | in ``IDLE_SHARE`` of its steps a robot waited, not on | waits         |
|                  |       | a charger                                             |               |
| late             | fleet | more than ``LATE_SHARE`` of the deliveries were late  | all           |
| served           | fleet | none of these                                         | all           |

*Needed* is the minimum number of steps to the delivery, ``PICK`` and ``DROP`` included. *Lost*
steps did not bring the robot nearer: all steps, less the ones needed at the start and no longer
needed at the end. Fewer than ``MIN_STEPS`` steps of a kind, or lost, are no evidence. Waiting and
running into walls change no pattern, because a visit to a cell may be of any length. Steps that
charged the battery are not lost, and count in no pattern.

A fleet that has delivered everything is late or served.
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

from warehouse_core.arguments import instance_of
from warehouse_core.motion.base import NOTHING
from warehouse_core.records.episode import (
    BATTERY_DEPLETED,
    DELIVERED,
    OUT_OF_TIME,
    UNFINISHED,
    Episode,
)
from warehouse_core.wording import brief, counted, listed
from warehouse_core.world.actions import DISPLACEMENTS, DROP, INVALID, PICK, WAIT, action_index
from warehouse_core.world.layout import Layout
from warehouse_core.world.tiles import WALL, Cell, moved

UNREACHABLE, STALLED, INEFFECTIVE = "unreachable", "stalled", "ineffective"
OSCILLATION, WANDERING = "oscillation", "wandering"
STRANDED, DEADLOCK, STARVATION = "stranded", "deadlock", "starvation"
CONGESTED, IDLE, LATE, SERVED = "congested", "idle", "late", "served"

CAUSE_SHARE = 0.4
"""Share of the lost steps; less than half, because a robot may be stuck more than once."""

LOST_SHARE = 0.5
"""Share of all moves, which a path twice as long as the shortest loses; and of the lost steps."""

MAX_SWING_CELLS = 4
"""Number of cells of a swing: the cell where the robot is stuck and up to three neighbours."""

MIN_STEPS = 2 * MAX_SWING_CELLS
"""Least evidence; fewer steps cannot show that it comes back to ``MAX_SWING_CELLS`` cells."""

ROUNDS = 3
"""Repetitions of the same cells in the same order that make a loop."""

MIN_STANDING = 10
"""Steps in one cell at the end; fewer may be a short stop."""

STOPPED_SHARE = 0.5
"""Share of these steps in which the same robot has to be in the way."""

MIN_OVERTAKING = 10
"""Orders taken before one that was released earlier; fewer may be a matter of place."""

BLOCKED_SHARE, IDLE_SHARE, LATE_SHARE = 0.25, 0.5, 0.5
"""Shares of the moves, of the steps of all robots, and of the deliveries."""

NO_MOVES = {INVALID: "unknown action", PICK: "useless pick", DROP: "useless drop", WAIT: "wait"}
"""Actions that move no robot by index, in the order in which they are checked."""

BUMP = "bump"
"""Name of a move that something stopped; it is checked last."""

ENDINGS = {
    BATTERY_DEPLETED: "the battery ran out",
    OUT_OF_TIME: "the time ran out",
    UNFINISHED: "it was stopped",
}

CellState = tuple[Cell, bool]
"""The cell of the robot, and whether it holds an item."""


class Diagnosis(NamedTuple):
    """The failure mode of an episode, with the evidence.

    Attributes:
        mode: One of ``MODES``, or of ``FLEET_MODES``.
        cells: Cells of the pattern in the order of the visits, for ``oscillation``; for
            ``unreachable`` the stations without a path, if there are any; for ``stalled`` the cell
            from which most steps missed theirs, and for ``congested`` the cell from which most
            moves were stopped; for ``starvation`` the pickup of the order; for other modes the
            last cells of the robots.
        steps: Number of steps of the evidence; the table at the top of this file says which.
        needed: Minimum number of steps from the start to the delivery, ``None`` without a path and
            for fleets.
        sentence: The evidence in words.
        robots: Numbers of the robots it is about, in ascending order; a queue or a ring from its
            first robot on; for ``starvation`` the robot that took the order, if one did.

    Example:
        >>> from agents import GreedyAgent
        >>> from warehouse_core import WarehouseEnv, record_episode
        >>> from warehouse_core.records import diagnose
        >>> agent = GreedyAgent(seed=1, escape_steps=0)
        >>> diagnosis = diagnose(record_episode(WarehouseEnv(), agent, seed=1))
        >>> diagnosis.mode, diagnosis.needed
        ('oscillation', 17)
        >>> diagnosis.sentence
        'swung between (1, 5), (2, 5), (3, 5) and (2, 6) for the last 200 steps'
    """

    mode: str
    cells: tuple[Cell, ...]
    steps: int
    needed: int | None
    sentence: str
    robots: tuple[int, ...] = (0,)


class Evidence(NamedTuple):
    """What a rule of ``TABLE`` says of an episode; see ``Diagnosis``."""

    sentence: str
    cells: Sequence[Cell]
    steps: int
    robots: Sequence[int] = (0,)


Rule = Callable[[Any], Evidence | None]
"""Function that returns the evidence for a mode, or ``None`` if the mode does not apply."""


class Alone:
    """The episode of a lone robot, and what the rules need to know about it.

    Attributes:
        needed: Minimum number of steps from the start to the delivery, ``None`` without a path.
        left: The same from the ``end``, which is the last cell and load of the robot.
        nearer: Number of needed steps that the robot has taken.
    """

    def __init__(self, episode: Episode) -> None:
        start, self.end = ((episode.cells[at], episode.loaded[at]) for at in (0, -1))
        self.episode = episode
        self.needed, self.left = needed, left = fewest_steps(episode.layout, start, self.end)
        self.nearer = 0 if needed is None or left is None else max(needed - left, 0)

    @cached_property
    def charging(self) -> set[int]:
        """The steps after which the battery had more units than before."""
        return {step for step, (a, b) in enumerate(pairwise(self.episode.battery)) if b > a}

    @cached_property
    def lost(self) -> int:
        """The number of lost steps."""
        return self.episode.steps - len(self.charging) - self.nearer

    @cached_property
    def missed(self) -> list[Cell]:
        """The start of each step that missed its cell with nothing in the way."""
        episode = self.episode
        deltas = {action: DISPLACEMENTS[action_index(action)] for action in set(episode.actions)}
        moves = zip(episode.cells, episode.actions, episode.motions, strict=False)
        return [
            cell
            for cell, action, motion in moves
            if motion.cell != moved(cell, deltas[action]) and not motion.blocked
        ]

    def least(self, share: float) -> float:
        """Return how many steps are this share of the lost steps, and enough to be evidence."""
        return max(MIN_STEPS, share * self.lost) if self.lost >= MIN_STEPS else math.inf

    @property
    def misses(self) -> str:
        """The end of a sentence that tells of steps that missed their cell."""
        return f"; {_count(len(self.missed))} missed their cell" if self.missed else ""


def diagnose(episode: Episode) -> Diagnosis:
    """Return the failure mode of an episode; it depends on the record only, not on the agent.

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
    results = (
        (mode, rule(alone or episode))
        for mode, *rules in TABLE
        if (rule := rules[episode.is_fleet]) and (mode in (LATE, SERVED) or not is_done)
    )
    mode, evidence = next((mode, evidence) for mode, evidence in results if evidence)
    sentence, cells, steps, robots = evidence
    return Diagnosis(mode, tuple(cells), steps, needed, sentence, tuple(robots))


def _delivered(alone: Alone) -> Evidence | None:
    if not alone.episode.terminated:
        return None
    steps = alone.episode.steps
    return Evidence(f"delivered in {_count(steps)}{_shortest(alone)}", alone.end[:1], steps)


def _cut_off(alone: Alone) -> Evidence | None:
    """Name the stations that no path leads to."""
    if alone.left is not None:
        return None
    (here, loaded), layout = alone.end, alone.episode.layout
    if loaded or not layout.reachable_from(here).isdisjoint(layout.pickups):
        name, stations = "dropoff", layout.dropoffs
    else:
        name, stations = "pickup", layout.pickups
    sentence = f"there is no {name}"
    if stations:
        sentence = f"no way leads from {here} to the {name} at {listed(stations, 'or')}"
    return Evidence(sentence, stations, alone.episode.steps)


def _stalled(alone: Alone) -> Evidence | None:
    misses = len(alone.missed)
    if misses < alone.least(CAUSE_SHARE):
        return None
    [(worst, times)] = Counter(alone.missed).most_common(1)
    sentence = (
        f"{misses} of {_count(alone.episode.steps)} missed their cell with nothing in the way, "
        f"{times} of them from {worst}"
    )
    return Evidence(sentence, (worst,), misses)


def _ineffective(alone: Alone) -> Evidence | None:
    """Count the steps that had no effect; if one kind is enough, only the first such kind."""
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
    came = f"came {_count(nearer)} nearer to the delivery" if nearer else "came no nearer"
    sentence = f"{came} in {moves} moves over {len(set(cells))} cells{alone.misses}"
    return Evidence(sentence, alone.end[:1], moves - nearer)


def _out_of(ending: str) -> Callable[[Alone], Evidence | None]:
    """Return the rule of a mode that says how the episode ended."""

    def find(alone: Alone) -> Evidence | None:
        if alone.episode.outcome != ending or alone.left is None:
            return None
        short = f"{ENDINGS[ending]} {_count(alone.left)} short of the delivery"
        return Evidence(f"{short}{_shortest(alone)}", alone.end[:1], alone.left)

    return find


def _shortest(alone: Alone) -> str:
    return "" if alone.needed is None else f"; the shortest way takes {alone.needed}"


def fewest_steps(layout: Layout, *states: CellState) -> tuple[int | None, ...]:
    """Return the minimum number of steps from each state to the delivery, ``None`` without a path.

    The search is breadth first and backwards from the dropoffs, with the item; at a pickup it
    continues without the item too.
    """
    stride = layout.width + 1
    edge = WALL * stride
    floor = edge + "".join([row + WALL for row in layout.rows]) + edge
    unloaded = len(floor)  # added to the number of a state with the item gives that without
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
    """Return the fewest cells that the robot stayed among at the end, and for how many steps.

    Its cells of the ``leg`` are all with the item or all without. If there were fewer steps than
    ``least``, the result is empty.
    """
    arrivals = [step for step, cell in enumerate(leg) if step == 0 or cell != leg[step - 1]]
    way = [leg[step] for step in arrivals]
    # After the last visit to a cell, it stayed among the cells whose last visits are later.
    farewells = sorted({cell: visit for visit, cell in enumerate(way)}.values(), reverse=True)
    for begin in [visit + 1 for visit in [*farewells[1:], -1][:MAX_SWING_CELLS]]:
        steps = len(leg) - 1 - arrivals[begin]
        if steps >= least and (begin == len(way) - 1 or way[begin] in way[begin + 1 :]):
            return tuple(dict.fromkeys(way[begin:])), steps
    begin = _loop_begin(way)
    steps = len(leg) - 1 - arrivals[begin]
    return (tuple(dict.fromkeys(way[begin:])), steps) if steps >= least else ((), 0)


def _loop_begin(way: Sequence[Cell]) -> int:
    """Return the visit after which a way is at least ``ROUNDS`` times one loop, or the last visit.

    This is the failure function of Knuth, Morris and Pratt, of the way backwards: the first ``k``
    visits begin and end with the same ``border[k]`` visits, so their period is ``k - border[k]``.
    """
    back, border, longest = way[::-1], [0, 0], 1
    for k, cell in enumerate(back[1:], start=2):
        shared = border[-1]
        while shared and back[shared] != cell:
            shared = border[shared]
        shared += back[shared] == cell
        border.append(shared)
        if k >= ROUNDS * (k - shared):
            longest = k
    return len(way) - longest


def _describe(swing: Sequence[Cell]) -> str:
    if len(swing) == 1:
        return f"stood on {swing[0]}"
    if len(swing) <= MAX_SWING_CELLS:
        return f"swung between {listed(swing)}"
    return f"went round and round over {len(swing)} cells, {swing[0]} among them,"


def _count(steps: int) -> str:
    return counted(steps, "step")


def _no_way(episode: Episode) -> Evidence | None:
    """Name the first order, not delivered, that no way leads to."""
    cells = _ends(episode)
    left = {number: each for number, each in enumerate(episode.orders) if each.delivered is None}
    for number, order in left.items():
        sent = order.robot if order.taken is None else order.taken_by
        robots = range(episode.robots) if sent is None else [sent]
        goal, name = (order.pickup, "pickup") if order.taken is None else (order.dropoff, "dropoff")
        reached = episode.layout.reachable_from(goal)
        if reached.isdisjoint(cells[robot] for robot in robots):
            who = _named(robots, cells) if len(robots) == 1 else "any robot"
            sentence = f"no way leads from {who} to the {name} of order {number} at {goal}"
            return Evidence(sentence, (goal,), episode.steps, robots)
    return None


def _stranded(episode: Episode) -> Evidence | None:
    robots, cells = np.flatnonzero(episode.battery[-1] <= 0).tolist(), _ends(episode)
    lost, failed = episode.measures.lost, episode.measures.stranded
    with_them = f", and {counted(lost, 'order')} with them" if lost else ""
    if not robots:
        # A record says of each robot when its battery is empty, and of failures how many there are.
        sentence = f"{counted(failed, 'robot')} failed for good{with_them}"
        return Evidence(sentence, (), 0, ()) if failed else None
    blocked = int(np.isin(episode.stopped_by, robots).sum())
    in_the_way = f" and stopped {counted(blocked, 'move')} of others" if blocked else ""
    sentence = f"the battery of {_named(robots, cells)} ran out{in_the_way}{with_them}"
    return Evidence(sentence, [cells[robot] for robot in robots], blocked, robots)


def _deadlock(episode: Episode) -> Evidence | None:
    """Find robots that stop each other in a ring, or the longest queue behind one that stays."""
    steps, ahead = _standing(episode)
    queues = {robot: _queue(robot, ahead) for robot in ahead}
    rings = [queue for queue in queues.values() if ahead.get(queue[-1]) == queue[0]]
    stuck = [queue for queue in queues.values() if steps[queue[-1]] >= MIN_STANDING]
    longest = max(rings or stuck, key=len, default=[])
    if not longest:
        return None
    since = min(steps[robot] for robot in longest)
    cells = _ends(episode)
    if rings:
        what = f"{_named(longest, cells)} stop each other"
        behind = [robot for robot in ahead if queues[robot] == longest and robot not in longest]
    else:
        *waiting, first = longest
        what = f"{_named(waiting, cells)} are stopped by {_named([first], cells)}, which stays"
        behind = []
    more = f"; behind them {_named(behind, cells)}" if behind else ""
    sentence = f"{what}, for the last {_count(since)}{more}"
    return Evidence(sentence, [cells[robot] for robot in longest], since, longest)


def _standing(episode: Episode) -> tuple[list[int], dict[int, int]]:
    """Return for how many steps each robot has not left its cell, and who stops whom."""
    steps: list[int] = []
    ahead: dict[int, int] = {}
    for robot, way in enumerate(episode.cells.T):
        changes = np.flatnonzero(way != way[-1])
        steps.append(len(way) - 2 - int(changes[-1]) if len(changes) else len(way) - 1)
        stops = episode.stopped_by[len(episode.stopped_by) - steps[-1] :, robot]
        [(by, times)] = Counter(stops.tolist()).most_common(1) or [(NOTHING, 0)]
        is_robot = 0 <= by < episode.robots
        if is_robot and steps[-1] >= MIN_STANDING and times >= STOPPED_SHARE * steps[-1]:
            ahead[robot] = by
    return steps, ahead


def _queue(robot: int, ahead: dict[int, int]) -> list[int]:
    """Return the robot, the one that stops it, and so on; or the ring that this leads to."""
    queue = [robot]
    while queue[-1] in ahead:
        following = ahead[queue[-1]]
        if following in queue:
            ring = queue[queue.index(following) :]
            first = ring.index(min(ring))
            return ring[first:] + ring[:first]
        queue.append(following)
    return queue


def _starvation(episode: Episode) -> Evidence | None:
    """Look whether the late order that waited longest was overtaken."""
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
        f"{_count(waits[worst])}, while {overtaking} that were released after it were taken"
    )
    robots = () if order.taken_by is None else (order.taken_by,)
    return Evidence(sentence, (order.pickup,), waits[worst], robots)


def _congested(episode: Episode) -> Evidence | None:
    by = episode.stopped_by
    moves, blocked = int((episode.counted_actions() < WAIT).sum()), int((by >= 0).sum())
    if not blocked or blocked < BLOCKED_SHARE * moves:
        return None
    [(worst, times)] = Counter(episode.cells[:-1][by >= 0].tolist()).most_common(1)
    cell = episode.layout.cell(worst)
    people = int((by >= episode.robots).sum())
    sentence = (
        f"{blocked} of {counted(moves, 'move')} were stopped by robots or people, {people} of them "
        f"by people; most, {times}, from {cell}"
    )
    return Evidence(sentence, (cell,), blocked, range(episode.robots))


def _idle(episode: Episode) -> Evidence | None:
    measures = episode.measures
    steps = measures.steps * episode.robots
    if not measures.waits or measures.waits < IDLE_SHARE * steps:
        return None
    sentence = (
        f"the robots waited in {measures.waits} of {_count(steps)}, with "
        f"{counted(measures.orders, 'order')} for {counted(episode.robots, 'robot')}"
    )
    return _of_all(episode, sentence, measures.waits)


def _late(episode: Episode) -> Evidence | None:
    measures = episode.measures
    if not measures.on_time < 1 - LATE_SHARE:
        return None
    late = round((1 - measures.on_time) * measures.delivered)
    sentence = (
        f"{late} of {measures.delivered} deliveries were late; the mean over all is "
        f"{measures.mean_lateness:.0f} steps"
    )
    return _of_all(episode, sentence, episode.steps)


def _served(episode: Episode) -> Evidence:
    return _of_all(episode, f"{episode.outcome} in {_count(episode.steps)}", episode.steps)


def _of_all(episode: Episode, sentence: str, steps: int) -> Evidence:
    """Return the evidence for a mode of all robots, with their last cells."""
    return Evidence(sentence, _ends(episode), steps, range(episode.robots))


def _ends(episode: Episode) -> list[Cell]:
    """Return where the robots are at the end."""
    return episode.layout.cells(episode.cells[-1])


def _named(robots: Sequence[int], cells: Sequence[Cell]) -> str:
    """Return robots and their cells in words."""
    return listed(f"robot {robot} at {cells[robot]}" for robot in robots)


TABLE: tuple[tuple[str, Rule | None, Rule | None], ...] = (
    (DELIVERED, _delivered, None),
    (UNREACHABLE, _cut_off, _no_way),
    (STALLED, _stalled, None),
    (INEFFECTIVE, _ineffective, None),
    (OSCILLATION, _oscillation, None),
    (WANDERING, _wandering, None),
    *((ending, _out_of(ending), None) for ending in ENDINGS),
    (STRANDED, None, _stranded),
    (DEADLOCK, None, _deadlock),
    (STARVATION, None, _starvation),
    (CONGESTED, None, _congested),
    (IDLE, None, _idle),
    (LATE, None, _late),
    (SERVED, None, _served),
)
"""Every mode, with its rule for ``Alone`` and its rule for the record of a fleet, in the order in
which they are checked; ``None`` where the mode does not apply."""

MODES = tuple(mode for mode, alone, _ in TABLE if alone)
"""Modes of a lone robot."""

FLEET_MODES = tuple(mode for mode, _, fleet in TABLE if fleet)
"""Modes of a fleet."""

FleetDiagnosis = Diagnosis
diagnose_fleet = diagnose
