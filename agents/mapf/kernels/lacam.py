"""LaCAM*: an anytime search over configurations, the places of all robots at once.

The search is depth-first. Each configuration has a tree of constraints, who must go where next,
of which each visit tries one more; a round of PIBT chooses the places of the others, or a round of
EPIBT where robots have headings. The tree is not stored: its nodes in breadth-first order are
numbers in mixed radix, whose digits are the steps of the first robots by priority. Its last level
has every joint step. Routes to configurations that are reached again become shorter, so that in the
end the plan is the cheapest, or it is proved that there is none.

The cost of a joint step is the number of robots that are not at their goals before and after it.

Source: Okumura (2023), Improving LaCAM for scalable eventually optimal multi-agent pathfinding,
IJCAI.
"""

from __future__ import annotations

from typing import NamedTuple

from agents.mapf.kernels.buffers import Buffer, Table, buffer, enlarged, kernel, prepare
from agents.mapf.kernels.epibt import Epibt
from agents.mapf.kernels.epibt import choose as choose_by_epibt
from agents.mapf.kernels.lns import improve
from agents.mapf.kernels.pibt import CHOSEN, Pibt
from agents.mapf.kernels.pibt import choose as choose_by_pibt
from agents.mapf.kernels.places import ACTIONS, NONE, Places, measure
from agents.mapf.kernels.robots import NOBODY, UNDECIDED, Robots, draw

SPENT, FULL, DONE, FOUND = 0, 1, 2, 3
"""Why a search returns: its rounds are over, a buffer is full, all is tried, there is a plan."""

RESTART = 1000
"""The first configuration is visited again at one in so many that are reached again."""


class Search(NamedTuple):
    """What is known of ``N`` configurations, of which there is room for more.

    Attributes:
        places: ``[N * R]``, the places of the robots.
        orders: ``[N * R]``, robots by falling priority.
        parent: ``[N]``, the configuration before on the cheapest way, or ``NONE``.
        cost: ``[N]``, cost of that way.
        left: ``[N]``, sum of the distances that are left.
        tried: ``[N]``, constraints that were tried.
        edges: ``[N]``, first of the edges that lead on, or ``NONE``.
        edge_to: ``[E]``, configuration that an edge leads to.
        edge_next: ``[E]``, next edge from the same configuration.
        table: hash table of the configurations plus one; 0 is free. Its size is a power of 2.
        opened: stack of configurations to visit.
        entries: ``[N]``, how often each is in the stack.
        queue: ``[N + 1]``, configurations whose ways have become cheaper.
        is_queued: ``[N]``, 1 for those in the queue.
        ranks: ``[R]``, robots by falling length of their ways.
        rows: ``[R]``, as in ``Robots``, of distances in steps.
        counts: ``[5]``: configurations, edges, height of the stack, last configuration of the
            best plan or ``NONE``, and 1 if the search goes on after the first plan.
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
"""Places in ``counts``."""

ROOM = 64
"""Configurations for which there is room at first."""

PER_NODE = ("parent", "cost", "left", "tried", "edges", "entries", "queue", "is_queued")
"""Buffers with a number for each configuration."""


def new_search(robots: int) -> Search:
    """Return the buffers of a search that knows nothing yet."""
    search = Search(
        places=buffer(ROOM * robots), orders=buffer(ROOM * robots), parent=buffer(ROOM),
        cost=buffer(ROOM), left=buffer(ROOM), tried=buffer(ROOM), edges=buffer(ROOM),
        edge_to=buffer(ROOM), edge_next=buffer(ROOM), table=buffer(4 * ROOM),
        opened=buffer(4 * ROOM), entries=buffer(ROOM), queue=buffer(ROOM + 1),
        is_queued=buffer(ROOM), ranks=buffer(robots), rows=buffer(robots), counts=buffer(5),
    )  # fmt: skip
    search.counts[BEST] = NONE
    return search


def enlarged_search(search: Search) -> Search:
    """Return a search with twice the room where it is short of it."""
    counts, short = search.counts, list[str]()
    if counts[NODES] == len(search.parent):
        short += [*PER_NODE, "places", "orders"]
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


@kernel
def is_full(search: Search) -> bool:
    """Return whether there is no room for another configuration, or another edge."""
    counts = search.counts
    is_short = counts[NODES] == len(search.parent) or counts[EDGES] == len(search.edge_to)
    # Each configuration that becomes cheaper is opened again.
    return is_short or counts[HEIGHT] + counts[NODES] + 1 >= len(search.opened)


@kernel
def slot_of(search: Search, places: Buffer, first: int) -> int:
    """Return where a configuration is in the hash table, or the free slot where it would be.

    Its places are those from ``first`` in a buffer.
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
    """Write all configurations into the hash table, which is empty."""
    for node in range(search.counts[NODES]):
        search.table[slot_of(search, search.places, node * len(search.ranks))] = node + 1


@kernel
def step_cost(search: Search, robots: Robots, floor: Places, node: int, after: int) -> int:
    """Return the cost of a joint step."""
    count, places, cost = len(robots.goals), search.places, 0
    for robot in range(count):
        goal = robots.goals[robot]
        is_there = places[node * count + robot] % floor.size == goal
        cost += not (is_there and places[after * count + robot] % floor.size == goal)
    return cost


@kernel
def push(search: Search, node: int) -> None:
    """Put a configuration on the stack of those to visit."""
    search.opened[search.counts[HEIGHT]] = node
    search.counts[HEIGHT] += 1
    search.entries[node] += 1


@kernel
def pop(search: Search) -> None:
    """Take the last configuration from the stack."""
    search.counts[HEIGHT] -= 1
    search.entries[search.opened[search.counts[HEIGHT]]] -= 1


@kernel
def add_edge(search: Search, node: int, after: int) -> None:
    """Add an edge from a configuration to another."""
    edge = search.counts[EDGES]
    search.edge_to[edge], search.edge_next[edge] = after, search.edges[node]
    search.edges[node] = edge
    search.counts[EDGES] += 1


@kernel
def add(search: Search, robots: Robots, floor: Places, steps: Table, parent: int, slot: int) -> int:
    """Add the configuration that robots have chosen, and open it; return its number."""
    counts, goals, chosen = search.counts, robots.goals, robots.chosen
    count, node, size = len(goals), counts[NODES], floor.size
    first, at, left = node * count, node * count, 0
    counts[NODES] += 1
    for robot in range(count):
        search.places[first + robot] = chosen[robot]
        left += steps[search.rows[robot] + chosen[robot]]
    # Robots keep their order until they reach their goals, and are the last from then on.
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


@kernel
def load(search: Search, robots: Robots, pibt: Pibt, node: int) -> None:
    """Let robots stand as in a configuration, with nothing chosen."""
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
    """Return the number of steps that a robot can take from a place; one of them is waiting."""
    found = 0
    for action in range(ACTIONS):
        found += floor.near[place * ACTIONS + action] != floor.closed
    return found


@kernel
def constrain(search: Search, robots: Robots, pibt: Pibt, floor: Places, node: int) -> int:
    """Let the first robots take the steps of the next constraint of a configuration.

    Returns:
        1 if they can, 0 if they cannot, ``NONE`` if all constraints were tried.
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
        if pibt.is_taken[to % size] or (swaps and robots.chosen[other] % size == place % size):
            return 0
        robots.chosen[robot], pibt.is_taken[to % size] = to, CHOSEN
    return 1


@kernel
def reach_again(search: Search, robots: Robots, floor: Places, node: int, after: int) -> None:
    """Take over an edge between known configurations, and what becomes cheaper by it."""
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
            if cost[here] + 1 <= cost[to]:  # no step is free but that from the goal to itself
                total = cost[here] + step_cost(search, robots, floor, here, to)
                if total < cost[to]:
                    cost[to], search.parent[to] = total, here
                    if not search.is_queued[to]:
                        search.queue[last], search.is_queued[to] = to, 1
                        last = (last + 1) % room
                    if not search.entries[to]:  # it was left because it was too expensive
                        push(search, to)
            edge = search.edge_next[edge]


@kernel
def explore(
    search: Search, robots: Robots, pibt: Pibt, epibt: Epibt, floor: Places, fields: Table,
    steps: Table, rounds: int,
) -> int:  # fmt: skip
    """Search on for some rounds of PIBT or EPIBT.

    Args:
        search: known configurations.
        robots: robots of any configuration.
        pibt: buffers of PIBT, whose ``is_taken`` is used with headings too.
        epibt: buffers of EPIBT if the robots have headings, else of no use.
        floor: floor of the robots.
        fields: distances that guide the robots.
        steps: distances in steps, which bound the costs.
        rounds: rounds after which the search pauses.

    Returns:
        ``SPENT``, ``FULL``, ``DONE`` or ``FOUND``.
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
        if left[node] == 0:  # with headings there are several such configurations
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
    """Compile the kernels of LaCAM, LaCAM* and refinement; what is compiled is kept.

    That takes some seconds once on a machine, which must not count against a limit of time.
    """
    prepare(measure, add, explore, fill_table, improve)
