"""A validator of plans, and graphs for networkx, which share no code with the planners.

A state of a delivery in a graph is ``(row, col, has_item)``, and ``END`` after the drop.
"""

import random
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import networkx as nx

Place = tuple[int, int]


class Prices(NamedTuple):
    """The costs of a move with empty hands, a move with the item, PICK and DROP."""

    empty: float
    loaded: float
    pick: float
    drop: float


END = "end"


@dataclass
class Replay:
    """The result of the actions of a plan: places from the start on, errors by action numbers."""

    place: Place
    has_item: bool = False
    cost: float = 0.0
    places: list[Place] = field(default_factory=list)
    errors: list[str] = field(default_factory=list)


def replay_route(rows: Sequence[str], start: Place, goal: Place, plan: Sequence[str]) -> Replay:
    """Replay a plan of moves that should end on the goal."""
    done = Replay(start, places=[start])
    for number, word in enumerate(plan):
        _drive(done, rows, number, word)
        done.cost += 1
    if done.place != goal:
        done.errors.append(f"ends on {done.place}, not on {goal}")
    return done


def replay_delivery(
    rows: Sequence[str],
    start: Place,
    has_item: bool,
    pickups: Collection[Place],
    dropoffs: Collection[Place],
    prices: Prices,
    plan: Sequence[str],
) -> Replay:
    """Replay a plan that should end with its only drop."""
    done, drops = Replay(start, has_item, places=[start]), []
    for number, word in enumerate(plan):
        if word == "PICK":
            done.cost += prices.pick
            if done.has_item or done.place not in pickups:
                done.errors.append(f"{number}: nothing to pick on {done.place}")
            done.has_item = True
            done.places.append(done.place)
        elif word == "DROP":
            done.cost += prices.drop
            if not done.has_item or done.place not in dropoffs:
                done.errors.append(f"{number}: nothing to drop on {done.place}")
            done.has_item = False
            drops.append(number)
            done.places.append(done.place)
        else:
            done.cost += prices.loaded if done.has_item else prices.empty
            _drive(done, rows, number, word)
    if drops != [len(plan) - 1]:
        done.errors.append(f"drops at {drops} of {len(plan)} actions")
    return done


def _drive(done: Replay, rows: Sequence[str], number: int, word: str) -> None:
    row, col = done.place
    if word not in ("N", "S", "W", "E"):
        done.errors.append(f"{number}: {word!r} is no move")
    row += (word == "S") - (word == "N")
    col += (word == "E") - (word == "W")
    if not (0 <= row < len(rows) and 0 <= col < len(rows[0])):
        done.errors.append(f"{number}: {word!r} leaves the grid")
    elif rows[row][col] == "#":
        done.errors.append(f"{number}: {word!r} hits a wall")
    done.place = row, col
    done.places.append(done.place)


def random_rows(stream: random.Random, min_size: int = 4, max_size: int = 9) -> list[str]:
    """Return random walls of a random density, without a border and often in several parts.

    At least one cell is open.
    """
    height, width = stream.randint(min_size, max_size), stream.randint(min_size, max_size)
    density = stream.uniform(0, 0.6)
    tiles = [
        ["#" if stream.random() < density else "." for _ in range(width)] for _ in range(height)
    ]
    tiles[stream.randrange(height)][stream.randrange(width)] = "."
    return ["".join(row) for row in tiles]


def open_places(rows: Sequence[str]) -> list[Place]:
    return [(r, c) for r, row in enumerate(rows) for c, tile in enumerate(row) if tile != "#"]


def random_prices(stream: random.Random) -> Prices:
    """Return prices in eighths, including 0: their sums are exact in any order."""
    return Prices(*(stream.choice((0.0, 1.0, stream.randrange(80) / 8)) for _ in Prices._fields))


def _steps(rows: Sequence[str]) -> list[tuple[Place, Place]]:
    """Return each pair of neighbouring open places once."""
    places = open_places(rows)
    known = set(places)
    return [
        (place, other)
        for place in places
        for other in ((place[0] + 1, place[1]), (place[0], place[1] + 1))
        if other in known
    ]


def route_graph(rows: Sequence[str]) -> nx.Graph:
    """Return the graph of the open places and the moves between them."""
    graph = nx.Graph()
    graph.add_nodes_from(open_places(rows))
    graph.add_edges_from(_steps(rows))
    return graph


def delivery_graph(
    rows: Sequence[str], pickups: Collection[Place], dropoffs: Collection[Place], prices: Prices
) -> nx.DiGraph:
    """Return the graph of the states of a delivery, each edge with its ``weight``."""
    graph = nx.DiGraph()
    graph.add_node(END)
    graph.add_nodes_from((r, c, load) for r, c in open_places(rows) for load in (False, True))
    for load, price in ((False, prices.empty), (True, prices.loaded)):
        pairs = [((r, c, load), (y, x, load)) for (r, c), (y, x) in _steps(rows)]
        graph.add_edges_from(pairs, weight=price)
        graph.add_edges_from([(there, here) for here, there in pairs], weight=price)
    lifts = [((r, c, False), (r, c, True)) for r, c in pickups]
    graph.add_edges_from(lifts, weight=prices.pick)
    graph.add_edges_from([((r, c, True), END) for r, c in dropoffs], weight=prices.drop)
    return graph
