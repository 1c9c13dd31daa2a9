import numpy as np

from agents.learning.traffic_view import AHEAD, IS_OPEN, OF_MOVE, SIZE, Traffic, TrafficView
from agents.mapf.graph import Fields, Graph
from warehouse_core import Layout
from warehouse_core.world.generators import maze_layout

N, E, S, W, STAY = range(5)


def turned(layout: Layout) -> Layout:
    """Return a layout turned by a quarter, clockwise."""
    return Layout(["".join(row) for row in zip(*layout.rows[::-1], strict=True)])


def turned_cells(layout: Layout, cells: np.ndarray) -> np.ndarray:
    rows, columns = np.divmod(cells, layout.width)
    return columns * layout.height + layout.height - 1 - rows


def look(view: TrafficView, fields: Fields, cells: np.ndarray, goals: np.ndarray) -> np.ndarray:
    order = np.arange(len(cells))[::-1]
    return view.look(Traffic(cells, goals, fields.rows(goals), order))


def cell_of(view: np.ndarray, number: int) -> np.ndarray:
    """Return what a view of a move shows of a cell of its way."""
    return view[OF_MOVE:].reshape(AHEAD, -1)[number]


def test_a_view_is_the_same_however_the_floor_is_turned() -> None:
    """Ways in a perfect maze are unique, so that nothing depends on the order of the moves."""
    layout = maze_layout(11, 13, seed=3).with_tiles((), (), ())
    stream, seen = np.random.default_rng(1), []
    steps = [stream.choice(layout.open_cells, (2, 12), replace=False) for _ in range(3)]
    for floor in (layout, turned(layout)):
        fields = Fields(Graph(floor))
        view = TrafficView(fields)
        for cells, goals in steps:
            places = (cells, goals)
            if floor is not layout:
                places = tuple(turned_cells(layout, each) for each in places)
            seen.append(look(view, fields, *places))
    for mine, theirs in zip(seen[:3], seen[3:], strict=True):
        assert np.array_equal(mine, theirs[:, [E, S, W, N, STAY]])
        assert mine.shape == (12, 5, SIZE)


def test_a_view_shows_who_comes_the_other_way() -> None:
    fields = Fields(Graph(Layout(["......", "######"])))
    [east, _] = look(TrafficView(fields), fields, np.array([0, 4]), np.array([5, 0]))
    assert east[[N, S, W], IS_OPEN].tolist() == [0, 0, 0]
    assert not east[[N, S, W]].any()
    occupied, along, against, waiting, before, at_once, with_me, against_me = range(8)
    ahead = cell_of(east[E], 3)
    assert ahead[[occupied, against, before]].tolist() == [1, 1, 1]
    assert ahead[[along, waiting]].tolist() == [0, 0]
    # Both are in cell 2 after two steps; each enters the cells between by the other's way back.
    assert [cell_of(east[E], number)[at_once] for number in range(3)] == [0, 1, 0]
    assert [cell_of(east[E], number)[against_me] for number in range(5)] == [1, 1, 1, 1, 0]
    assert [cell_of(east[E], number)[with_me] for number in range(5)] == [0, 0, 0, 0, 0]
    assert not cell_of(east[E], 5).any()  # beyond the goal


def test_a_robot_sees_nobody_where_there_is_nobody() -> None:
    """Its own way, which is among all that are counted, is not another robot's."""
    fields = Fields(Graph(Layout(["....", "...."])))
    [alone] = look(TrafficView(fields), fields, np.array([0]), np.array([3]))
    on_way = alone[:, OF_MOVE:].reshape(5, AHEAD, -1)
    assert not on_way[..., :8].any()
