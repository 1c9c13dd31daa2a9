"""Ways among reservations."""

import pytest

from agents.mapf.graph import Graph
from agents.mapf.space_time import Reservations, find_way, moves_of
from warehouse_core import Layout

ROOM = Layout(["#####", "#...#", "##.##", "#####"])
"""Cells 6, 7 and 8 in a row, and 12 below 7."""


def way_of(taken: Reservations, start: int, goal: int, **options) -> list[int] | None:
    graph = Graph(ROOM)
    field = graph.distances(goal).tolist()
    return find_way(moves_of(graph), field, start, goal, taken, **options)


@pytest.fixture
def taken() -> Reservations:
    return Reservations(20)


def test_a_goal_is_occupied_for_good(taken: Reservations) -> None:
    taken.add([12, 7])
    assert way_of(taken, 6, 8) is None
    taken = Reservations(20)
    taken.add([12, 12, 7])
    assert way_of(taken, 6, 8) == [6, 7, 8]


def test_a_way_ends_after_others_have_passed_the_goal(taken: Reservations) -> None:
    taken.add([8, 8, 8, 7, 12])
    way = way_of(taken, 6, 7)
    assert way is not None
    assert (len(way), way[3], way[4]) == (5, 6, 7)


def test_nobody_changes_places(taken: Reservations) -> None:
    taken.add([7, 6, 6, 7, 8])
    assert way_of(taken, 6, 12) is None


def test_after_the_latest_reservation_times_are_alike(taken: Reservations) -> None:
    taken.add([8, 8, 8])
    assert way_of(taken, 6, 12) == [6, 7, 12]
    assert way_of(taken, 6, 8) is None


def test_the_deadline_is_kept(taken: Reservations) -> None:
    with pytest.raises(TimeoutError):
        way_of(taken, 6, 8, deadline=0.0)
