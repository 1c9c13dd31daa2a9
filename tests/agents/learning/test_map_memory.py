import numpy as np
import pytest

from agents.learning.map_memory import MapMemory, turns, view_size
from warehouse_core import BatchEnv, Layout, random_layout
from warehouse_core.world.actions import ACTIONS
from warehouse_core.world.tiles import DROPOFF, PICKUP, WALL

RADIUS = 3
PICK = ACTIONS.index("PICK")


def walk(layout: Layout, start: tuple[int, int], actions: list[int]) -> list[np.ndarray]:
    """Return the views of one robot, before each action and after the last."""
    batch = BatchEnv(1, layout, start, randomize=False)
    memory = MapMemory(1, 2, RADIUS)
    views = [memory.look(batch.reset(seed=1)[0])[0]]
    for action in actions:
        views.append(memory.look(batch.step([action])[0])[0])
    return views


def turned(layout: Layout, quarters: int, mirrored: bool) -> Layout:
    tiles = np.array([list(row) for row in layout.rows])
    tiles = np.rot90(tiles[:, ::-1] if mirrored else tiles, quarters)
    return Layout(["".join(row) for row in tiles])


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("quarters", range(4))
def test_turning_the_robot_equals_turning_the_floor(quarters: int, mirrored: bool) -> None:
    layout = random_layout(9, 9, 0.2, seed=4)
    start, stream = layout.cell(layout.open_cells[5]), np.random.default_rng(1)
    actions = stream.integers(4, size=60).tolist()
    there = turned(layout, quarters, mirrored)
    marks = np.zeros((9, 9), bool)
    marks[start] = True
    marks = np.rot90(marks[:, ::-1] if mirrored else marks, quarters)
    [place] = np.argwhere(marks).tolist()
    # In a mirror, a move to the east leads west. A quarter turn is counterclockwise.
    moves = [((0, 3, 2, 1)[action] if mirrored else action) for action in actions]
    moves = [(move - quarters) % 4 for move in moves]
    look = turns(RADIUS)[int(mirrored), (-quarters) % 4 if mirrored else quarters]
    for view, other in zip(
        walk(layout, start, actions), walk(there, (place[0], place[1]), moves), strict=True
    ):
        assert np.array_equal(view[look], other)


def test_a_view_shows_what_a_robot_has_done() -> None:
    layout = Layout(["#####", "#P.D#", "#####"])
    east, west = ACTIONS.index("E"), ACTIONS.index("W")
    first, at_east, back = walk(layout, (1, 1), [east, west])
    by_move = [view[:36].reshape(9, 4) for view in (first, at_east, back)]
    assert by_move[0][4].tolist() == [1, 0, 1, 1], "walls"
    assert by_move[0][8].tolist() == [1, 1, 1, 1], "exits that are new"
    assert by_move[1][5].tolist() == [0, 1, 0, 0], "the last move"
    assert by_move[1][6].tolist() == [0, 0, 0, 1], "the pickup is in the west"
    assert np.allclose(by_move[1][7], [0, 0, 0, 0.1]), "one cell away"
    assert np.allclose(by_move[1][3], [0, 0, 0, np.log(2)]), "it came from the west"
    assert np.allclose(by_move[1][1], [0, 0, 0, 1 / 4]), "visits over those in the east"
    assert np.allclose(by_move[2][2], [0, np.log(2), 0, 0]), "it has left to the east once"
    assert np.isclose(back[-1], np.log(3)), "its second visit"


def test_the_moves_to_the_pickup_are_forgotten_there_and_the_map_is_not() -> None:
    layout = Layout(["########", "#P....D#", "########"])
    west = ACTIONS.index("W")
    before, after = walk(layout, (1, 6), [west] * 5 + [PICK])[-2:]
    cells = slice(36, None)
    seen = [view[cells][: 4 * 49].reshape(4, 49) for view in (before, after)]
    assert np.array_equal(seen[0][:2], seen[1][:2]), "walls and free cells"
    assert (seen[0][2] > 0).sum() == 4, "cells visited within three of the robot"
    assert (seen[1][2] > 0).sum() == 1, "only where it is"


def test_a_map_grows_with_the_floor() -> None:
    near = random_layout(9, 9, 0.2, seed=4)
    rows = [WALL * 120] * 70 + [row.rjust(120, WALL) for row in near.rows]
    start = near.cell(near.open_cells[5])
    actions = np.random.default_rng(2).integers(4, size=60).tolist()
    far = walk(Layout(rows), (start[0] + 70, start[1] + 111), actions)
    for here, there in zip(walk(near, start, actions), far, strict=True):
        assert np.array_equal(here, there)


def test_known_cells_are_kept_when_a_map_grows() -> None:
    layout = Layout([WALL * 80, WALL + PICKUP + "." * 76 + DROPOFF + WALL, WALL * 80])
    east, west = ACTIONS.index("E"), ACTIONS.index("W")
    views = walk(layout, (1, 20), [east] * 30 + [west] * 30)
    assert np.isclose(views[-1][-1], np.log(3)), "the start has been visited twice"


def test_robots_forget_one_by_one() -> None:
    batch, memory = BatchEnv(3, autoreset_mode="NextStep"), MapMemory(3, 2, RADIUS)
    arrays, info = batch.reset(seed=1)
    first = memory.look(arrays)
    moved = memory.look(batch.step(info["action_mask"].argmax(axis=1))[0])
    memory.forget(np.array([False, True, False]))
    again = memory.look(arrays)
    assert np.array_equal(again[1], first[1])
    assert not np.array_equal(again[0], first[0])
    assert moved.shape == (3, view_size(RADIUS))
