"""LaCAM*: lazy constraints addition search over configurations, the places of all robots at once.

The search is depth-first. Each configuration has a tree of constraints, which say which robot must
go where next. Each visit to a configuration tries one more constraint. A round of PIBT then chooses
the places of the other robots, or a round of EPIBT if the robots have headings.

The constraint tree is not stored. Its nodes in breadth-first order are numbers in mixed radix,
whose digits are the steps of the robots of highest priority. The deepest level contains every joint
step. When the search reaches a known configuration again, it updates the costs of all
configurations that become cheaper. The search therefore ends with an optimal plan, or with the
proof that no plan exists.

The cost of a joint step is the number of robots that are not at their goals both before and after
it.

Source: Okumura (2023), Improving LaCAM for scalable eventually optimal multi-agent pathfinding,
IJCAI.
"""

from __future__ import annotations

from typing import NamedTuple

from agents.mapf.kernels.buffers import Buffer, Table, buffer, buffer_of, enlarged
from agents.mapf.kernels.epibt import Epibt
from agents.mapf.kernels.epibt import choose as choose_by_epibt
from agents.mapf.kernels.lns import improve
from agents.mapf.kernels.local_guidance import Guidance, guide
from agents.mapf.kernels.pibt import Pibt
from agents.mapf.kernels.pibt import choose as choose_by_pibt
from agents.mapf.kernels.places import ACTIONS, NONE, Places, measure
from agents.mapf.kernels.robots import NOBODY, UNDECIDED, Robots, draw
from warehouse_core.compiled import kernel, prepare
from warehouse_core.world.tables import Integers

SPENT, FULL, DONE, FOUND = 0, 1, 2, 3
"""Why a search returns: no rounds left, a buffer is full, the search is complete, a plan exists."""

RESTART = 1000
"""Once in this many times, reaching a known configuration revisits the first one instead."""


class Search(NamedTuple):
    """Search graph with ``N`` configurations of ``R`` robots and ``E`` edges, with spare capacity.

    Attributes:
        places: ``[N * R]``, the places of the robots.
        orders: ``[N * R]``, robots by decreasing priority.
        parent: ``[N]``, previous configuration on the cheapest path, or ``NONE``.
        cost: ``[N]``, cost of that path.
        left: ``[N]``, sum of the robots' remaining distances (the heuristic).
        tried: ``[N]``, number of constraints that were tried.
        edges: ``[N]``, first outgoing edge, or ``NONE``.
        edge_to: ``[E]``, configuration that an edge leads to.
        edge_next: ``[E]``, next edge from the same configuration.
        table: hash table of configuration numbers plus one; 0 is a free slot. Its size is a power
            of 2.
        opened: stack of configurations to visit.
        entries: ``[N]``, number of times that each configuration is in the stack.
        queue: ``[N + 1]``, configurations whose paths have become cheaper.
        is_queued: ``[N]``, 1 for the configurations in the queue.
        ranks: ``[R]``, robots by decreasing length of their paths.
        rows: ``[R]``, as in ``Robots``, for distances in steps.
        counts: ``[5]``: number of configurations, number of edges, height of the stack, last
            configuration of the best plan or ``NONE``, and 1 if the search continues after the
            first plan.
    """

    places: Buffer
    orders: Buffer
    parent: Buffer
    cost: Buffer
    left: Buffer
    tried: Buffer
    edges: Buffer
    edge_to: Buffer
    edge_next: Buffer
    table: Buffer
    opened: Buffer
    entries: Buffer
    queue: Buffer
    is_queued: Buffer
    ranks: Buffer
    rows: Buffer
    counts: Buffer


NODES, EDGES, HEIGHT, BEST, ANYTIME = range(5)
"""Indices of ``counts``."""

ROOM = 64
"""Capacity in configurations at the start."""


def enlarged_search(search: Search) -> Search:
    """Return a search in which every buffer that is nearly full has twice the capacity."""
    counts, short = search.counts, list[str]()
    if counts[NODES] == len(search.parent):
        short += ["parent", "cost", "left", "tried", "edges", "entries", "queue", "is_queued"]
        short += ["places", "orders"]
    if counts[EDGES] == len(search.edge_to):
        short += ["edge_to", "edge_next"]
    if counts[HEIGHT] + counts[NODES] + 1 >= len(search.opened):
        short += ["opened"]
    old = search._asdict()
    search = search._replace(**{name: enlarged(old[name], 2 * len(old[name])) for name in short})
    if "places" in short:
        search = search._replace(table=buffer(2 * len(search.table)))
        fill_table(search)
    return search


def best_places(search: Search) -> list[Buffer]:
    """Return the places of the robots before and after each step of the best plan, if any."""
    count, node, places = len(search.ranks), int(search.counts[BEST]), list[Buffer]()
    while node != NONE:
        places.append(search.places[node * count : (node + 1) * count])
        node = int(search.parent[node])
    return places[::-1]


@kernel
def is_full(search: Search) -> bool:
    """Return whether the buffers lack room for another configuration or another edge."""
    counts = search.counts
    is_short = counts[NODES] == len(search.parent) or counts[EDGES] == len(search.edge_to)
    # Each configuration that becomes cheaper is opened again.
    return is_short or counts[HEIGHT] + counts[NODES] + 1 >= len(search.opened)


@kernel
def slot_of(search: Search, places: Buffer, first: int) -> int:
    """Return the slot of a configuration in the hash table, or the free slot that it would get.

    The places of the configuration begin at index ``first`` of a buffer.
    """
    count, table, known = len(search.ranks), search.table, search.places
    mask, key = len(table) - 1, 0
    for robot in range(count):
        key = ((key ^ places[first + robot]) * 0x9E3779B1) & 0xFFFFFFFFFF
        key ^= key >> 15
    slot = (key ^ (key >> 20)) & mask
    while table[slot]:
        other, robot = (table[slot] - 1) * count, 0
        while robot < count and known[other + robot] == places[first + robot]:
            robot += 1
        if robot == count:
            return slot
        slot = (slot + 1) & mask
    return slot


@kernel
def fill_table(search: Search) -> None:
    """Write all configurations into the empty hash table."""
    for node in range(search.counts[NODES]):
        search.table[slot_of(search, search.places, node * len(search.ranks))] = node + 1


@kernel
def step_cost(search: Search, robots: Robots, floor: Places, node: int, after: int) -> int:
    """Return the cost of the joint step from a configuration to another."""
    count, places, cost = len(robots.goals), search.places, 0
    for robot in range(count):
        goal = robots.goals[robot]
        is_there = places[node * count + robot] % floor.size == goal
        cost += not (is_there and places[after * count + robot] % floor.size == goal)
    return cost


@kernel
def push(search: Search, node: int) -> None:
    """Push a configuration onto the stack of configurations to visit."""
    search.opened[search.counts[HEIGHT]] = node
    search.counts[HEIGHT] += 1
    search.entries[node] += 1


@kernel
def pop(search: Search) -> None:
    """Pop the last configuration from the stack."""
    search.counts[HEIGHT] -= 1
    search.entries[search.opened[search.counts[HEIGHT]]] -= 1


@kernel
def add_edge(search: Search, node: int, after: int) -> None:
    """Add an edge between two configurations."""
    edge = search.counts[EDGES]
    search.edge_to[edge], search.edge_next[edge] = after, search.edges[node]
    search.edges[node] = edge
    search.counts[EDGES] += 1


@kernel
def add(search: Search, robots: Robots, floor: Places, steps: Table, parent: int, slot: int) -> int:
    """Add the configuration that the robots have chosen, push it, and return its number."""
    counts, goals, chosen = search.counts, robots.goals, robots.chosen
    count, node, size = len(goals), counts[NODES], floor.size
    first, at, left = node * count, node * count, 0
    counts[NODES] += 1
    for robot in range(count):
        search.places[first + robot] = chosen[robot]
        left += steps[search.rows[robot] + chosen[robot]]
    # Robots keep their order until they reach their goals. From then on they come last.
    for number in range(count):
        robot = search.ranks[number] if parent == NONE else search.orders[parent * count + number]
        if chosen[robot] % size != goals[robot]:
            search.orders[at] = robot
            at += 1
    for number in range(count):
        robot = search.ranks[number]
        if chosen[robot] % size == goals[robot]:
            search.orders[at] = robot
            at += 1
    search.parent[node], search.left[node], search.tried[node] = parent, left, 0
    search.cost[node], search.edges[node] = 0, NONE
    search.table[slot] = node + 1
    if parent != NONE:
        search.cost[node] = search.cost[parent] + step_cost(search, robots, floor, parent, node)
    search.entries[node] = search.is_queued[node] = 0
    push(search, node)
    return node


def new_search(
    robots: Robots, floor: Places, steps: Table, ranks: Integers, rows: Integers
) -> Search:
    """Return a search from the configuration that the robots have chosen; see ``Search``."""
    count = len(robots.goals)
    search = Search(
        places=buffer(ROOM * count), orders=buffer(ROOM * count), parent=buffer(ROOM),
        cost=buffer(ROOM), left=buffer(ROOM), tried=buffer(ROOM), edges=buffer(ROOM),
        edge_to=buffer(ROOM), edge_next=buffer(ROOM), table=buffer(4 * ROOM),
        opened=buffer(4 * ROOM), entries=buffer(ROOM), queue=buffer(ROOM + 1),
        is_queued=buffer(ROOM), ranks=buffer_of(ranks), rows=buffer_of(rows), counts=buffer(5),
    )  # fmt: skip
    search.counts[BEST] = NONE
    add(search, robots, floor, steps, NONE, slot_of(search, robots.chosen, 0))
    return search


@kernel
def load(search: Search, robots: Robots, pibt: Pibt, node: int) -> None:
    """Place the robots as in a configuration, with nothing chosen."""
    count, size = len(robots.goals), robots.size
    for robot in range(count):
        robots.robot_in[robots.places[robot] % size] = NOBODY
        if robots.chosen[robot] != UNDECIDED:
            pibt.is_taken[robots.chosen[robot] % size] = 0
    for robot in range(count):
        place = search.places[node * count + robot]
        robots.places[robot], robots.chosen[robot] = place, UNDECIDED
        robots.order[robot] = search.orders[node * count + robot]
        robots.robot_in[place % size] = robot


@kernel
def options(floor: Places, place: int) -> int:
    """Return the number of steps, including waiting, that a robot can take from a place."""
    number = 0
    for action in range(ACTIONS):
        number += floor.near[place * ACTIONS + action] != floor.closed
    return number


@kernel
def constrain(search: Search, robots: Robots, pibt: Pibt, floor: Places, node: int) -> int:
    """Move the first robots as the next constraint of a configuration demands.

    Returns:
        1 if they can move this way, 0 if they cannot, and ``NONE`` if all constraints were tried.
    """
    number, size, near = search.tried[node], floor.size, floor.near
    depth, block = 0, 1
    while number >= block:
        number -= block
        if depth == len(robots.order):
            return NONE
        block *= options(floor, robots.places[robots.order[depth]])
        depth += 1
    search.tried[node] += 1
    for at in range(depth):
        robot = robots.order[at]
        place = robots.places[robot]
        width = options(floor, place)
        digit, action = (number + node + at) % width, -1
        number //= width
        while digit >= 0:
            action += 1
            digit -= near[place * ACTIONS + action] != floor.closed
        to = near[place * ACTIONS + action]
        other = robots.robot_in[to % size]
        swaps = other not in (NOBODY, robot) and robots.chosen[other] != UNDECIDED
        is_shut = pibt.is_taken[to % size] or robots.is_closed[to % size]
        if is_shut or (swaps and robots.chosen[other] % size == place % size):
            return 0
        robots.chosen[robot], pibt.is_taken[to % size] = to, 1
    return 1


@kernel
def reach_again(search: Search, robots: Robots, floor: Places, node: int, after: int) -> None:
    """Add an edge between known configurations, and update all costs that become lower."""
    cost = search.cost
    edge = search.edges[node]
    while edge != NONE:
        if search.edge_to[edge] == after:
            break
        edge = search.edge_next[edge]
    if edge == NONE:
        add_edge(search, node, after)
    first, last = 0, 1
    search.queue[0] = node
    room = len(search.queue)
    while first != last:
        here, first = search.queue[first], (first + 1) % room
        search.is_queued[here] = 0
        edge = search.edges[here]
        while edge != NONE:
            to = search.edge_to[edge]
            if cost[here] + 1 <= cost[to]:  # only waiting at the goal is free
                total = cost[here] + step_cost(search, robots, floor, here, to)
                if total < cost[to]:
                    cost[to], search.parent[to] = total, here
                    if not search.is_queued[to]:
                        search.queue[last], search.is_queued[to] = to, 1
                        last = (last + 1) % room
                    if not search.entries[to]:  # it was dropped when it was too expensive
                        push(search, to)
            edge = search.edge_next[edge]


@kernel
def explore(
    search: Search, robots: Robots, pibt: Pibt, epibt: Epibt, guidance: Guidance, floor: Places,
    fields: Table, steps: Table, rounds: int,
) -> int:  # fmt: skip
    """Continue the search for at most ``rounds`` rounds of PIBT or EPIBT.

    Return ``SPENT``, ``FULL``, ``DONE`` or ``FOUND``. Robots with headings use ``epibt``, and
    ``is_taken`` of ``pibt``. The distances in ``fields`` guide the robots. Those in ``steps`` are
    lower bounds on the costs.
    """
    counts, cost, left = search.counts, search.cost, search.left
    done = 0
    while counts[HEIGHT] > 0:
        if is_full(search):
            return FULL
        if done == rounds:
            return SPENT
        node, best = search.opened[counts[HEIGHT] - 1], counts[BEST]
        if best != NONE and cost[node] + left[node] >= cost[best]:
            pop(search)
            continue
        if left[node] == 0:  # with headings several configurations have all robots at their goals
            counts[BEST] = node
            if counts[ANYTIME] == 0:
                return FOUND
            continue
        load(search, robots, pibt, node)
        state = constrain(search, robots, pibt, floor, node)
        if state == NONE:
            pop(search)
            continue
        done += 1
        if state == 0:
            continue
        if floor.closed == floor.size:
            is_new = search.tried[node] == 1
            guide(floor, robots, guidance, steps, search.rows, pibt.wishes, is_new)
            is_complete = choose_by_pibt(floor, robots, pibt, fields)
        else:
            is_complete = choose_by_epibt(robots, epibt, fields)
        if not is_complete:
            continue
        slot = slot_of(search, robots.chosen, 0)
        after = search.table[slot] - 1
        if after == NONE:
            after = add(search, robots, floor, steps, node, slot)
            add_edge(search, node, after)
        elif after != node:
            reach_again(search, robots, floor, node, after)
            again = after if draw(robots.random) % RESTART else 0
            if best == NONE or cost[again] + left[again] < cost[counts[BEST]]:
                push(search, again)
    return DONE


def prepare_solvers() -> None:
    """Compile the kernels of LaCAM, LaCAM* and LNS, and cache the result on disk.

    The first compilation on a machine takes some seconds, which must not count against a time
    limit.
    """
    prepare(measure, add, explore, fill_table, improve)
