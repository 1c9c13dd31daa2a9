"""Whether robots of a fleet among people could pick or deliver anything, found by brute force.

Robots move as they like. People who walk to stations only come nearer to those that they walk to,
which planners do not know, or stand; after that, and along aisles, they walk anywhere. So work is
called possible too where people would have to be lucky, and where the search is given up.
"""

from heapq import heappop, heappush
from typing import Any

import numpy as np

from warehouse_core import FleetEnv
from warehouse_core.world.distances import distances
from warehouse_core.world.tiles import Cell

MAX_STATES = 15_000
SIDES = (0, 1), (1, 0), (0, -1), (-1, 0)


def can_work(env: FleetEnv) -> bool:
    """Return whether there are moves with which a robot picks or delivers an order that waits."""
    people, waiting = walks(env), [env.orders[index].pickup for index in env.open_orders]
    for robot, cell in enumerate(env.cells):
        index = env.order_of[robot]
        if env.loaded[robot] and index is not None:
            targets = [env.orders[index].dropoff]
        else:
            targets = waiting if index is None else [*waiting, env.orders[index].pickup]
        others = frozenset(env.cells) - {cell}
        if any(has_way(env, cell, others, people, target) for target in {*targets}):
            return True
    return False


def walks(env: FleetEnv) -> list[Any]:
    """Return the distances to where each person walks, or ``None``."""
    crowd: Any = env._engine.crowd
    if not crowd._walks_to_stations:
        return [None] * len(env.people)
    ways, fields = crowd._ways, []
    for goal in crowd._goals[0].tolist():
        first = ways._first[0] + goal * ways._size[0]
        number = int(np.flatnonzero(ways._is_goal[first : first + ways._size[0]])[0])
        fields.append(distances(env.layout, [env.layout.cell(number)]))
    return fields


def has_way(
    env: FleetEnv, start: Cell, others: frozenset[Cell], fields: list[Any], target: Cell
) -> bool:
    """Return whether a robot can get to a cell, or the search for it was given up."""
    ways = distances(env.layout, [target])
    people = tuple((cell, field is None) for cell, field in zip(env.people, fields, strict=True))
    first = start, others, people
    known, heap = {first}, [(ways[start], 0, first)]
    while heap:
        chief, robots, people = heappop(heap)[-1]
        if chief == target or len(known) > MAX_STATES:
            return True
        taken, after = {chief, *robots, *(cell for cell, _ in people)}, list[Any]()
        for cell in (chief, *robots, *(cell for cell, _ in people)):
            for down, right in SIDES:
                to = cell[0] + down, cell[1] + right
                if to in taken or not env.layout.is_open(to):
                    continue
                if cell == chief:
                    after.append((to, robots, people))
                elif cell in robots:
                    after.append((chief, robots - {cell} | {to}, people))
                else:
                    [person] = [at for at, each in enumerate(people) if each[0] == cell]
                    field = fields[person]
                    is_free = people[person][1] or field[cell] == 0
                    if is_free or field[to] < field[cell]:
                        moved = (*people[:person], (to, is_free), *people[person + 1 :])
                        after.append((chief, robots, moved))
        for state in after:
            if state not in known:
                known.add(state)
                heappush(heap, (ways[state[0]], len(known), state))
    return False
