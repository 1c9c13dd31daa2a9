"""The failure mode of a fleet's episode: what a viewer of its replay would name.

``diagnose_fleet`` returns the first of these modes that applies; one always does.

| mode        | applies when                                                       | ``robots``   |
| ----------- | ------------------------------------------------------------------ | ------------ |
| unreachable | no way leads from a robot to the pickup of the order that waits    | those sent   |
|             | for it or to where its item is due; or from any robot to an open   |              |
|             | order                                                              |              |
| stranded    | the battery of a robot ran out, or a robot failed for good         | the first    |
| deadlock    | for ``MIN_STEPS`` steps up to the end robots did not leave their   | those that   |
|             | cells, each stopped by the next one: in a ring, or in a queue      | are stopped  |
|             | behind one that stays                                              |              |
| starvation  | an order waited while ``MIN_OVERTAKING`` orders that were released | taker, or    |
|             | after it were taken                                                | none         |
| congested   | ``BLOCKED_SHARE`` of the moves were stopped by robots or people    | all          |
| idle        | in ``IDLE_SHARE`` of its steps a robot waited, not on a charger    | all          |
| late        | ``LATE_SHARE`` of the deliveries were late                         | all          |
| served      | none of these                                                      | all          |

An episode in which everything was delivered is ``late`` or ``served``.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from warehouse_core.motion.vector import NOTHING
from warehouse_core.records.episode import FleetEpisode
from warehouse_core.wording import counted, listed
from warehouse_core.world.actions import WAIT
from warehouse_core.world.tiles import Cell

UNREACHABLE, STRANDED, DEADLOCK, STARVATION = "unreachable", "stranded", "deadlock", "starvation"
CONGESTED, IDLE, LATE, SERVED = "congested", "idle", "late", "served"

FLEET_MODES = (UNREACHABLE, STRANDED, DEADLOCK, STARVATION, CONGESTED, IDLE, LATE, SERVED)
"""Every mode, in the order in which they are checked."""

MIN_STEPS = 10
"""Steps in one cell at the end; fewer may be a short stop."""

MIN_OVERTAKING = 10
"""Orders taken before one that was released earlier; fewer may be a matter of place."""

BLOCKED_SHARE, IDLE_SHARE, LATE_SHARE = 0.25, 0.5, 0.5


class FleetDiagnosis(NamedTuple):
    """The failure mode of a fleet's episode, with the evidence.

    Attributes:
        mode: one of ``FLEET_MODES``.
        robots: those it is about, in ascending order; a queue or a ring from its first robot on.
        sentence: the evidence in words.
    """

    mode: str
    robots: tuple[int, ...]
    sentence: str


def diagnose_fleet(episode: FleetEpisode) -> FleetDiagnosis:
    """Return the failure mode of an episode; it depends on the record only."""
    result = f"{episode.outcome} in {counted(episode.steps, 'step')}"
    served = FleetDiagnosis(SERVED, _all(episode), result)
    if episode.terminated.all():
        return _late(episode) or served
    causes = (_unreachable, _stranded, _deadlock, _starvation, _congested, _idle, _late)
    return next(filter(None, (find(episode) for find in causes)), served)


def _unreachable(episode: FleetEpisode) -> FleetDiagnosis | None:
    """Name the first order, not delivered, that no way leads to."""
    cells = _ends(episode)
    for number, order in enumerate(episode.orders):
        if order.delivered is not None:
            continue
        sent = [order.taken_by] if order.taken is not None else [order.robot]
        robots = [robot for robot in sent if robot is not None] or list(_all(episode))
        goal, name = (order.pickup, "pickup") if order.taken is None else (order.dropoff, "dropoff")
        reached = episode.layout.reachable_from(goal)
        if reached.isdisjoint(cells[robot] for robot in robots):
            who = _named(robots, cells) if len(robots) == 1 else "any robot"
            sentence = f"no way leads from {who} to the {name} of order {number} at {goal}"
            return FleetDiagnosis(UNREACHABLE, tuple(robots), sentence)
    return None


def _stranded(episode: FleetEpisode) -> FleetDiagnosis | None:
    robots = tuple(np.flatnonzero(episode.battery[-1] <= 0).tolist())
    lost = (
        f", and {counted(episode.measures.lost, 'item')} with them" if episode.measures.lost else ""
    )
    if not robots and episode.measures.stranded:
        # A record says of each robot when its battery is empty, and of failures how many there are.
        failed = counted(episode.measures.stranded, "robot")
        return FleetDiagnosis(STRANDED, (), f"{failed} failed for good{lost}")
    if not robots:
        return None
    blocked = int(np.isin(episode.stopped_by, robots).sum())
    in_the_way = f" and stopped {counted(blocked, 'move')} of others" if blocked else ""
    sentence = f"the battery of {_named(robots, _ends(episode))} ran out{in_the_way}{lost}"
    return FleetDiagnosis(STRANDED, robots, sentence)


def _deadlock(episode: FleetEpisode) -> FleetDiagnosis | None:
    """Find robots that stop each other in a ring, or the longest queue behind one that stays."""
    steps, ahead = _standing(episode)
    queues = {robot: _queue(robot, ahead) for robot in ahead}
    rings = [queue for queue in queues.values() if ahead.get(queue[-1]) == queue[0]]
    stuck = [queue for queue in queues.values() if steps[queue[-1]] >= MIN_STEPS]
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
    sentence = f"{what}, for the last {counted(since, 'step')}{more}"
    return FleetDiagnosis(DEADLOCK, tuple(longest), sentence)


def _standing(episode: FleetEpisode) -> tuple[list[int], dict[int, int]]:
    """Return for how many steps each robot has not left its cell, and who stops whom.

    A robot is stopped by the one that stopped it most often, in at least half of these steps.
    """
    steps: list[int] = []
    ahead: dict[int, int] = {}
    for robot, way in enumerate(episode.cells.T):
        changes = np.flatnonzero(way != way[-1])
        steps.append(len(way) - 2 - int(changes[-1]) if len(changes) else len(way) - 1)
        stops = episode.stopped_by[len(episode.stopped_by) - steps[-1] :, robot]
        [(by, times)] = Counter(stops.tolist()).most_common(1) or [(NOTHING, 0)]
        is_robot = 0 <= by < episode.robots
        if is_robot and steps[-1] >= MIN_STEPS and times >= steps[-1] / 2:
            ahead[robot] = by
    return steps, ahead


def _queue(robot: int, ahead: dict[int, int]) -> list[int]:
    """Return the robot, the one that stops it, and so on; of a ring that it leads to, the ring."""
    queue = [robot]
    while queue[-1] in ahead:
        following = ahead[queue[-1]]
        if following in queue:
            ring = queue[queue.index(following) :]
            first = ring.index(min(ring))
            return ring[first:] + ring[:first]
        queue.append(following)
    return queue


def _starvation(episode: FleetEpisode) -> FleetDiagnosis | None:
    """Look whether the order that waited longest was overtaken."""
    waits = [
        (episode.steps if order.taken is None else order.taken) - order.released
        for order in episode.orders
    ]
    if not waits:
        return None
    worst = int(np.argmax(waits))
    order, end = episode.orders[worst], episode.orders[worst].released + waits[worst]
    overtaking = sum(
        1
        for other in episode.orders
        if other.released > order.released and other.taken is not None and other.taken < end
    )
    if overtaking < MIN_OVERTAKING:
        return None
    sentence = (
        f"order {worst} at {order.pickup} waited for {counted(waits[worst], 'step')}, while "
        f"{overtaking} that were released after it were taken"
    )
    robots = () if order.taken_by is None else (order.taken_by,)
    return FleetDiagnosis(STARVATION, robots, sentence)


def _congested(episode: FleetEpisode) -> FleetDiagnosis | None:
    by = episode.stopped_by
    moves, blocked = int((episode.actions < WAIT).sum()), int((by >= 0).sum())
    if not blocked or blocked < BLOCKED_SHARE * moves:
        return None
    [(worst, times)] = Counter(episode.cells[:-1][by >= 0].tolist()).most_common(1)
    people = int((by >= episode.robots).sum())
    sentence = (
        f"{blocked} of {counted(moves, 'move')} were stopped by robots or people, {people} of them "
        f"by people; most, {times}, from {divmod(worst, episode.layout.width)}"
    )
    return FleetDiagnosis(CONGESTED, _all(episode), sentence)


def _idle(episode: FleetEpisode) -> FleetDiagnosis | None:
    measures = episode.measures
    steps = measures.steps * episode.robots
    if not measures.waits or measures.waits < IDLE_SHARE * steps:
        return None
    sentence = (
        f"the robots waited in {measures.waits} of {counted(steps, 'step')}, with "
        f"{counted(measures.orders, 'order')} for {counted(episode.robots, 'robot')}"
    )
    return FleetDiagnosis(IDLE, _all(episode), sentence)


def _late(episode: FleetEpisode) -> FleetDiagnosis | None:
    measures = episode.measures
    if not measures.on_time < 1 - LATE_SHARE:
        return None
    late = round((1 - measures.on_time) * measures.delivered)
    sentence = (
        f"{late} of {measures.delivered} deliveries were late; the mean over all is "
        f"{measures.mean_lateness:.0f} steps"
    )
    return FleetDiagnosis(LATE, _all(episode), sentence)


def _all(episode: FleetEpisode) -> tuple[int, ...]:
    """Return the numbers of all robots."""
    return tuple(range(episode.robots))


def _ends(episode: FleetEpisode) -> list[Cell]:
    """Return where the robots are at the end."""
    return [divmod(cell, episode.layout.width) for cell in episode.cells[-1].tolist()]


def _named(robots: Sequence[int], cells: Sequence[Cell]) -> str:
    """Return robots and their cells in words."""
    return listed(f"robot {robot} at {cells[robot]}" for robot in robots)
