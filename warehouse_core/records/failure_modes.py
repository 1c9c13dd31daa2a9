"""The failure mode of an episode: the pattern that a viewer of its replay would name.

``diagnose`` returns the first of these modes that applies; one always does.

| mode             | applies when                                                   | ``steps``    |
| ---------------- | -------------------------------------------------------------- | ------------ |
| delivered        | the item was delivered                                         | of all       |
| unreachable      | no path leads to a pickup and then to a dropoff, or, with the  | of all       |
|                  | item picked up, to a dropoff                                   |              |
| stalled          | ``CAUSE_SHARE`` of the lost steps missed their cell: with      | that missed  |
|                  | nothing in its way the robot stayed, or slid to another cell   |              |
| ineffective      | ``LOST_SHARE`` of the lost steps had no effect: unknown        | without      |
|                  | actions, useless picks or drops, waits, or bumps               | effect       |
| oscillation      | for as many steps up to the end it stayed on one cell, swung   | at the end   |
|                  | between up to ``MAX_SWING_CELLS``, or repeated one loop of any |              |
|                  | size ``ROUNDS`` times                                          |              |
| wandering        | ``LOST_SHARE`` of its moves from cell to cell were lost        | lost moves   |
| battery depleted | none of these, and the battery ran out                         | needed still |
| out of time      | none of these, and the steps ran out                           | needed still |
| unfinished       | none of these, and the driver of the robot stopped             | needed still |

*Needed* is the minimum number of steps to the delivery, ``PICK`` and ``DROP`` included. *Lost*
steps did not bring the robot nearer: their number is that of all steps minus those needed at the
start and no longer needed at the end. Fewer than ``MIN_STEPS`` steps of a kind, or lost, are no
evidence. Waiting and running into walls change no pattern, because a visit to a cell may be of any
length. Steps that charged the battery are not lost, and count in no pattern.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from itertools import pairwise
from operator import ne
from typing import NamedTuple

from warehouse_core.records.episode import (
    BATTERY_DEPLETED,
    DELIVERED,
    OUT_OF_TIME,
    UNFINISHED,
    Episode,
)
from warehouse_core.wording import brief, counted, listed
from warehouse_core.world.actions import (
    DISPLACEMENTS,
    DROP,
    INVALID,
    PICK,
    WAIT,
    action_index,
)
from warehouse_core.world.layout import Layout
from warehouse_core.world.tiles import WALL, Cell

UNREACHABLE, STALLED, INEFFECTIVE = "unreachable", "stalled", "ineffective"
OSCILLATION, WANDERING = "oscillation", "wandering"

MODES = (
    DELIVERED, UNREACHABLE, STALLED, INEFFECTIVE, OSCILLATION, WANDERING,
    BATTERY_DEPLETED, OUT_OF_TIME, UNFINISHED,
)  # fmt: skip
"""Every mode, in the order in which they are checked."""

CAUSE_SHARE = 0.4
"""Of the lost steps; less than half, because a robot may be stuck more than once."""

LOST_SHARE = 0.5
"""Of all moves, which a path twice as long as the shortest loses; and of the lost steps."""

MAX_SWING_CELLS = 4
"""The cell where the robot is stuck and up to three neighbours."""

MIN_STEPS = 2 * MAX_SWING_CELLS
"""Steps; fewer cannot show that it comes back to ``MAX_SWING_CELLS`` cells."""

ROUNDS = 3
"""Repetitions of the same cells in the same order that make a loop."""

IDLE = {INVALID: "unknown action", PICK: "useless pick", DROP: "useless drop", WAIT: "wait"}
"""Actions that move no robot by index, in the order in which they are checked."""

BUMP = "bump"
"""A move that something stopped; checked last."""

ENDINGS = {
    BATTERY_DEPLETED: "the battery ran out",
    OUT_OF_TIME: "the time ran out",
    UNFINISHED: "it was stopped",
}

State = tuple[Cell, bool]
"""The cell of the robot, and whether it holds an item."""


class Diagnosis(NamedTuple):
    """The failure mode of an episode, with the evidence.

    Attributes:
        mode: one of ``MODES``.
        cells: for ``oscillation`` those of the pattern, in the order of the visits; for
            ``unreachable`` the stations without a path, if there are any; for ``stalled`` the
            cell from which most steps missed theirs; for other modes the last cell.
        steps: of the evidence; the table at the top of this file says which.
        needed: the minimum number of steps from the start to the delivery, ``None`` without a path.
        sentence: the evidence in words.
    """

    mode: str
    cells: tuple[Cell, ...]
    steps: int
    needed: int | None
    sentence: str


def diagnose(episode: Episode) -> Diagnosis:
    """Return the failure mode of an episode; it depends on the record only, not on the agent."""
    start, end = (episode.cells[0], episode.loaded[0]), (episode.cells[-1], episode.loaded[-1])
    needed, left = fewest_steps(episode.layout, start, end)
    shortest = "" if needed is None else f"; the shortest way takes {needed}"
    if episode.terminated:
        sentence = f"delivered in {_count(episode.steps)}{shortest}"
        return Diagnosis(DELIVERED, end[:1], episode.steps, needed, sentence)
    if left is None:
        stations, sentence = _cut_off(episode.layout, end)
        return Diagnosis(UNREACHABLE, stations, episode.steps, needed, sentence)
    lost = _why_lost(episode, needed, 0 if needed is None else max(needed - left, 0))
    if lost is not None:
        return lost
    sentence = f"{ENDINGS[episode.outcome]} {_count(left)} short of the delivery{shortest}"
    return Diagnosis(episode.outcome, end[:1], left, needed, sentence)


def _why_lost(episode: Episode, needed: int | None, nearer: int) -> Diagnosis | None:
    """Return the diagnosis of the lost steps, ``None`` if there is no pattern in them."""
    charging = set(_charging(episode))
    cells, lost = episode.cells, episode.steps - len(charging) - nearer
    if lost < MIN_STEPS:
        return None
    least = max(MIN_STEPS, CAUSE_SHARE * lost)
    missed = _missed(episode)
    misses = len(missed)
    if misses >= least:
        [(worst, times)] = Counter(missed).most_common(1)
        sentence = (
            f"{misses} of {_count(episode.steps)} missed their cell with nothing in the way, "
            f"{times} of them from {worst}"
        )
        return Diagnosis(STALLED, (worst,), misses, needed, sentence)
    idle = _ineffective(episode, charging, least=max(MIN_STEPS, LOST_SHARE * lost))
    if idle is not None:
        steps, sentence = idle
        return Diagnosis(INEFFECTIVE, (cells[-1],), steps, needed, sentence)
    also = f"; {_count(misses)} missed their cell" if misses else ""
    first = episode.loaded.index(episode.loaded[-1])
    leg = [cell for step, cell in enumerate(cells[first:], first) if step - 1 not in charging]
    swing, steps = _find_swing(leg, least)
    if swing:
        sentence = f"{_describe(swing)} for the last {_count(steps)}{also}"
        return Diagnosis(OSCILLATION, swing, steps, needed, sentence)
    moves = sum(map(ne, cells, cells[1:]))
    if moves - nearer >= max(MIN_STEPS, LOST_SHARE * moves):
        came = f"came {_count(nearer)} nearer to the delivery" if nearer else "came no nearer"
        sentence = f"{came} in {moves} moves over {len(set(cells))} cells{also}"
        return Diagnosis(WANDERING, (cells[-1],), moves - nearer, needed, sentence)
    return None


def fewest_steps(layout: Layout, *states: State) -> tuple[int | None, ...]:
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
    found: dict[int, int | None] = dict.fromkeys(sought)
    pickups, frontier = set(map(number, layout.pickups)), list(map(number, layout.dropoffs))
    steps = 0
    while frontier and None in found.values():
        steps += 1
        ahead: list[int] = []
        for here in frontier:
            if fresh[here]:
                fresh[here] = 0
                ahead += (here - stride, here + 1, here + stride, here - 1)
                if here in pickups:
                    ahead.append(here + unloaded)
        for state in sought:
            if found[state] is None and not fresh[state]:
                found[state] = steps
        frontier = ahead
    return tuple(found[state] for state in sought)


def _cut_off(layout: Layout, end: State) -> tuple[tuple[Cell, ...], str]:
    """Return the stations that no path leads to, and a sentence about them."""
    here, loaded = end
    if loaded or not layout.reachable_from(here).isdisjoint(layout.pickups):
        name, stations = "dropoff", layout.dropoffs
    else:
        name, stations = "pickup", layout.pickups
    if not stations:
        return (), f"there is no {name}"
    return stations, f"no way leads from {here} to the {name} at {listed(stations, 'or')}"


def _missed(episode: Episode) -> list[Cell]:
    """Return the start of each step that missed its cell with nothing in the way."""
    deltas = {action: DISPLACEMENTS[action_index(action)] for action in set(episode.actions)}
    asked = [deltas[action] for action in episode.actions]
    return [
        cell
        for cell, (down, right), motion in zip(episode.cells, asked, episode.motions, strict=False)
        if motion.cell != (cell[0] + down, cell[1] + right) and not motion.blocked
    ]


def _charging(episode: Episode) -> list[int]:
    """Return the steps after which the battery had more units than before."""
    return [step for step, (a, b) in enumerate(pairwise(episode.battery)) if b > a]


def _ineffective(episode: Episode, charging: set[int], least: float) -> tuple[int, str] | None:
    """Return how many steps had no effect, and a sentence; ``None`` if fewer than ``least``.

    If the steps of one kind are enough, they are those of the first such kind.
    """
    found: dict[str, Counter[str]] = {kind: Counter() for kind in (*IDLE.values(), BUMP)}
    states = list(zip(episode.cells, episode.loaded, strict=True))
    for step, (action, motion, before, after) in enumerate(
        zip(episode.actions, episode.motions, states, states[1:], strict=False)
    ):
        index = action_index(action)
        if before == after and step not in charging and (index in IDLE or motion.blocked):
            detail = brief(action) if index == INVALID else f"at {before[0]}"
            found[IDLE.get(index, BUMP)][detail] += 1
    alone = [kind for kind, details in found.items() if details.total() >= least][:1]
    kinds = alone or [kind for kind, details in found.items() if details]
    steps = sum(found[kind].total() for kind in kinds)
    if steps < least:
        return None
    sentence = listed(counted(found[kind].total(), kind) for kind in kinds)
    if len(kinds) == 1:
        [(detail, times)] = found[kinds[0]].most_common(1)
        sentence += f": {detail}" if times == steps else f", {times} of them {detail}"
    return steps, sentence


def _find_swing(leg: Sequence[Cell], least: float) -> tuple[tuple[Cell, ...], int]:
    """Return the fewest cells that the robot stayed among at the end, and for how many steps.

    Args:
        leg: its cells step by step, all with the item or all without.
        least: minimum number of steps; without such cells the result is empty.
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
