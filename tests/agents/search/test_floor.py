import random

from helpers.plan_validator import open_places, random_rows

from agents.search.problems import floor_of
from warehouse_core import Layout
from warehouse_core.world.generators import random_layout


def test_the_moves_from_a_cell_lead_to_the_open_cells_beside_it() -> None:
    floor = floor_of(Layout(["..#", "...", "#.."]))
    assert floor[1, 1] == (
        ("N", (0, 1), 1.0), ("E", (1, 2), 1.0), ("S", (2, 1), 1.0), ("W", (1, 0), 1.0),
    )  # fmt: skip
    assert floor[0, 0] == (("E", (0, 1), 1.0), ("S", (1, 0), 1.0)), "north and west is the edge"
    assert floor[2, 2] == (("N", (1, 2), 1.0), ("W", (2, 1), 1.0)), "south and east is the edge"


def test_every_move_can_be_taken_back() -> None:
    back = {"N": "S", "E": "W", "S": "N", "W": "E"}
    stream = random.Random(1)
    for _ in range(100):
        rows = random_rows(stream)
        floor = floor_of(Layout(rows))
        for place in open_places(rows):
            for move, cell, cost in floor[place]:
                assert (back[move], place, cost) in floor[cell]


def test_layouts_that_differ_in_their_stations_share_a_floor() -> None:
    layout = random_layout(9, 9, 0.2, seed=1)
    cells = [layout.open_cell(index) for index in range(4)]
    floor = floor_of(layout)
    assert floor_of(layout.with_stations(cells[0], cells[1])) is floor
    assert floor_of(layout.with_stations(cells[3], None)) is floor
    assert floor_of(Layout(layout.rows)) is floor


def test_stations_are_no_walls() -> None:
    assert floor_of(Layout(["PDP"]))[0, 1] == (("E", (0, 2), 1.0), ("W", (0, 0), 1.0))


def test_layouts_with_other_walls_have_other_floors() -> None:
    assert floor_of(Layout(["..#"]))[0, 1] == (("W", (0, 0), 1.0),)
    assert floor_of(Layout(["#.."]))[0, 1] == (("E", (0, 2), 1.0),)
    assert floor_of(Layout(["...", "..."]))[0, 2] == (("S", (1, 2), 1.0), ("W", (0, 1), 1.0))
    assert floor_of(Layout(["......"]))[0, 2] == (("E", (0, 3), 1.0), ("W", (0, 1), 1.0))


def test_only_what_is_asked_for_is_worked_out() -> None:
    """A great hall costs nothing before a search comes there, and a cell is worked out once."""
    floor = floor_of(Layout(["." * 701] * 5))
    assert not floor
    moves = floor[2, 350]
    assert floor.keys() == {(2, 350)}
    assert floor[2, 350] is moves


def test_few_floors_are_kept() -> None:
    """Thousands of layouts in an experiment would fill the memory."""
    layout = Layout(["." * 702])
    floor = floor_of(layout)
    for width in range(1, 30):
        floor_of(Layout(["." * width]))
    assert floor_of(layout) is not floor
