"""What became of an episode, in one of the words that a watcher of its replay would use.

``diagnose`` gives every episode the first of these modes that holds; one always does.

| mode             | holds when                                                     | ``steps``    |
| ---------------- | -------------------------------------------------------------- | ------------ |
| delivered        | the item was delivered                                         | of all       |
| unreachable      | no way leads on to a pickup and then to a dropoff, or with the | of all       |
|                  | item in hand to a dropoff                                      |              |
| stalled          | steps missed their cell, as many as ``CAUSE_SHARE`` of those   | that missed  |
|                  | lost: with nothing in its way it stayed, or slid to another    |              |
| oscillation      | for as many steps up to the end it stood on one cell, swung    | at the end   |
|                  | between ``FEW_CELLS`` or fewer, or went round one loop of any  |              |
|                  | size ``ROUNDS`` times                                          |              |
| wandering        | of its moves from cell to cell ``LOST_SHARE`` were lost        | lost moves   |
| battery depleted | none of these, and the battery ran out                         | needed still |
| out of time      | none of these, and the steps ran out                           | needed still |
| unfinished       | none of these, and whoever drove the robot stopped             | needed still |

*Needed* are the fewest steps to the delivery, round the walls, ``PICK`` and ``DROP`` included.
*Lost* are as many as did not bring it nearer: all of the episode less what was needed at its start
and no longer at its end. Fewer than ``PROOF`` steps of a kind, or lost, prove nothing. Waiting and
running into walls change no pattern, since a visit to a cell may be of any length.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from operator import ne
from typing import NamedTuple

from warehouse_core.records.episode import (
    BATTERY_DEPLETED,
    DELIVERED,
    OUT_OF_TIME,
    UNFINISHED,
    Episode,
)
from warehouse_core.wording import counted, listed
from warehouse_core.world.actions import DISPLACEMENTS, action_index
from warehouse_core.world.layout import Layout
from warehouse_core.world.tiles import WALL, Cell

UNREACHABLE, STALLED = "unreachable", "stalled"
OSCILLATION, WANDERING = "oscillation", "wandering"

MODES = (
    DELIVERED, UNREACHABLE, STALLED, OSCILLATION, WANDERING,
    BATTERY_DEPLETED, OUT_OF_TIME, UNFINISHED,
)  # fmt: skip
"""Every mode, in the order in which they are tried."""

CAUSE_SHARE = 0.4
"""Of the lost steps; less than half, because a robot may be stuck twice before the end."""

LOST_SHARE = 0.5
"""Of all moves; so many are lost on a way twice as long as the shortest."""

FEW_CELLS = 4
"""A robot that is stuck swings between the cell where it is stuck and up to three neighbours."""

PROOF = 2 * FEW_CELLS
"""Steps; in fewer it cannot be seen to come back to so many cells."""

ROUNDS = 3
"""Times round the same cells in the same order, before it is a loop."""

LAST_WORDS = {
    BATTERY_DEPLETED: "the battery ran out",
    OUT_OF_TIME: "the time ran out",
    UNFINISHED: "it was stopped",
}

State = tuple[Cell, bool]
"""Where the robot is, and whether it holds an item."""


class Diagnosis(NamedTuple):
    """What became of an episode, with the evidence.

    Attributes:
        mode: one of ``MODES``.
        cells: those it swung between or went round, in the order in which it came to them; the
            stations that are cut off, none where there are none; the cell from which most steps
            missed theirs; for all other modes the cell where it was last.
        steps: how many the evidence is about; the table at the top of this file says which.
        needed: the fewest steps from the start to the delivery, ``None`` where no way leads there.
        sentence: the evidence in words.
    """

    mode: str
    cells: tuple[Cell, ...]
    steps: int
    needed: int | None
    sentence: str


def diagnose(episode: Episode) -> Diagnosis:
    """Name what became of an episode, whatever its agent knew or meant."""
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
    sentence = f"{LAST_WORDS[episode.outcome]} {_count(left)} short of the delivery{shortest}"
    return Diagnosis(episode.outcome, end[:1], left, needed, sentence)


def _why_lost(episode: Episode, needed: int | None, nearer: int) -> Diagnosis | None:
    """Say what the steps were lost to that did not bring the robot nearer."""
    cells, lost = episode.cells, episode.steps - nearer
    if lost < PROOF:
        return None
    least = max(PROOF, CAUSE_SHARE * lost)
    missed = _missed(episode)
    misses = len(missed)
    if misses >= least:
        [(worst, times)] = Counter(missed).most_common(1)
        sentence = (
            f"{misses} of {_count(episode.steps)} missed their cell with nothing in the way, "
            f"{times} of them from {worst}"
        )
        return Diagnosis(STALLED, (worst,), misses, needed, sentence)
    also = f"; {_count(misses)} missed their cell" if misses else ""
    swing, steps = _find_swing(cells[episode.loaded.index(episode.loaded[-1]) :], least)
    if swing:
        sentence = f"{_describe(swing)} for the last {_count(steps)}{also}"
        return Diagnosis(OSCILLATION, swing, steps, needed, sentence)
    moves = sum(map(ne, cells, cells[1:]))
    if moves - nearer >= max(PROOF, LOST_SHARE * moves):
        came = f"came {_count(nearer)} nearer to the delivery" if nearer else "came no nearer"
        sentence = f"{came} in {moves} moves over {len(set(cells))} cells{also}"
        return Diagnosis(WANDERING, (cells[-1],), moves - nearer, needed, sentence)
    return None


def fewest_steps(layout: Layout, *states: State) -> tuple[int | None, ...]:
    """Return the fewest steps from each state to the delivery, ``None`` where no way leads there.

    The search goes backwards from the dropoffs, breadth first, with the item in hand; from a
    pickup it goes on with empty hands as well.
    """
    stride = layout.width + 1
    edge = WALL * stride
    floor = edge + "".join([row + WALL for row in layout.rows]) + edge
    unloaded = len(floor)  # how far the number of a state without an item is from one with it
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
    """Return the stations that no way leads to, and a sentence about them."""
    here, loaded = end
    if loaded or not layout.reachable_from(here).isdisjoint(layout.pickups):
        name, stations = "dropoff", layout.dropoffs
    else:
        name, stations = "pickup", layout.pickups
    if not stations:
        return (), f"there is no {name}"
    return stations, f"no way leads from {here} to the {name} at {listed(stations, 'or')}"


def _missed(episode: Episode) -> list[Cell]:
    """Return from where each step started that missed its cell with nothing in the way."""
    deltas = {action: DISPLACEMENTS[action_index(action)] for action in set(episode.actions)}
    asked = [deltas[action] for action in episode.actions]
    return [
        cell
        for cell, (down, right), motion in zip(episode.cells, asked, episode.motions, strict=False)
        if motion.cell != (cell[0] + down, cell[1] + right) and not motion.blocked
    ]


def _find_swing(leg: Sequence[Cell], least: float) -> tuple[tuple[Cell, ...], int]:
    """Return the cells that the robot kept to at the end, and for how many steps.

    Args:
        leg: where it was, step by step, all the while with the item or all without.
        least: steps; of what lasted as long it is the one with the fewest cells. None if none did.
    """
    arrivals = [step for step, cell in enumerate(leg) if step == 0 or cell != leg[step - 1]]
    way = [leg[step] for step in arrivals]
    # Once it had left a cell for good, it kept to the cells that it left later than that one.
    farewells = sorted({cell: visit for visit, cell in enumerate(way)}.values(), reverse=True)
    for begin in [visit + 1 for visit in [*farewells[1:], -1][:FEW_CELLS]]:
        steps = len(leg) - 1 - arrivals[begin]
        if steps >= least and (begin == len(way) - 1 or way[begin] in way[begin + 1 :]):
            return tuple(dict.fromkeys(way[begin:])), steps
    begin = _loop_begin(way)
    steps = len(leg) - 1 - arrivals[begin]
    return (tuple(dict.fromkeys(way[begin:])), steps) if steps >= least else ((), 0)


def _loop_begin(way: Sequence[Cell]) -> int:
    """Return the visit from which on a way is ``ROUNDS`` times one loop or more, or else the last.

    The failure function of Knuth, Morris and Pratt, of the way backwards: the first ``k`` visits
    begin with the same ``border[k]`` that they end with, so they recur every ``k - border[k]``.
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
    if len(swing) <= FEW_CELLS:
        return f"swung between {listed(swing)}"
    return f"went round and round over {len(swing)} cells, {swing[0]} among them,"


def _count(steps: int) -> str:
    return counted(steps, "step")
