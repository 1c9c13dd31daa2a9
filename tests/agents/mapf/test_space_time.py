"""Ways among reservations."""

import pytest

from agents.mapf.graph import Graph
from agents.mapf.reservations import Reservations
from agents.mapf.space_time import find_way, moves_of
from warehouse_core import Layout

ROOM = Layout(["#####", "#...#", "##.##", "#####"])
"""Cells 6, 7 and 8 in a row, and 12 below 7."""


def way_of(taken: Reservations, start: int, goal: int, **options) -> list[int] | None:
    graph = Graph(ROOM)
    options = {"end": taken.free_from(goal), **options}
    way = find_way(moves_of(graph), graph.distances(goal).tolist(), start, goal, taken, **options)
    return None if way is None else way.cells


@pytest.fixture
def taken() -> Reservations:
    return Reservations(20)


def test_a_goal_is_occupied_for_good(taken: Reservations) -> None:
    taken.add(0, [12, 7], stays=True)
    assert way_of(taken, 6, 8) is None
    taken = Reservations(20)
    taken.add(0, [12, 12, 7], stays=True)
    assert way_of(taken, 6, 8) == [6, 7, 8]
    assert way_of(taken, 8, 6, begin=1) is None
    assert way_of(taken, 8, 6, begin=100) is None


def test_a_way_ends_after_others_have_passed_the_goal(taken: Reservations) -> None:
    taken.add(0, [8, 8, 8, 7, 12], stays=True)
    way = way_of(taken, 6, 7)
    assert way is not None
    assert (len(way), way[3], way[4]) == (5, 6, 7)
    assert way_of(taken, 6, 7, end=0) == [6, 7]


def test_a_window_ends_a_way_on_its_edge(taken: Reservations) -> None:
    taken.add(0, [7, 7, 7, 8])
    assert way_of(taken, 6, 12, begin=0, window=2) == [6, 6, 6]
    assert way_of(taken, 6, 12, begin=0, window=4) == [6, 6, 6, 7, 12]
    taken.add(1, [12, 12, 12, 12, 12])
    assert way_of(taken, 6, 12, begin=0, window=3) == [6, 6, 6, 7]


def test_ways_begin_at_any_time(taken: Reservations) -> None:
    taken.add(0, [7, 7, 8], begin=5)
    assert way_of(taken, 6, 7, begin=5, window=9) == [6, 6, 7]
    assert way_of(taken, 6, 7, begin=7, window=9) == [6, 7]


def test_tolls_are_paid_for_the_fewest_conflicts(taken: Reservations) -> None:
    taken.add(0, [7] * 9)
    assert way_of(taken, 6, 8, window=4) == [6] * 5
    assert way_of(taken, 6, 8, end=0, toll=0.5) == [6, 7, 8]
    assert taken.rivals(1, [6, 7, 8]) == {0}
    assert taken.rivals(0, [6, 7, 8]) == set()
    assert taken.rivals(1, [6, 6, 6]) == set()


def test_who_would_change_places_is_a_rival(taken: Reservations) -> None:
    taken.add(3, [7, 6])
    assert taken.rivals(1, [6, 7]) == {3}


def test_closed_states_cost_no_toll_but_are_closed(taken: Reservations) -> None:
    taken.close([7], range(1, 4))
    assert way_of(taken, 6, 8, toll=0.5) == [6, 6, 6, 6, 7, 8]
    assert not taken.is_free(20 + 7)


def test_what_was_reserved_can_be_removed(taken: Reservations) -> None:
    taken.add(0, [7, 7, 8], begin=3)
    taken.add(1, [8, 8, 7], begin=0)
    taken.remove(0)
    taken.remove(1)
    taken.remove(2)
    assert not taken.states
    assert not taken.moves


def test_the_deadline_is_kept(taken: Reservations) -> None:
    with pytest.raises(TimeoutError):
        way_of(taken, 6, 8, deadline=0.0)
