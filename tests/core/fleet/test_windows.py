"""The windows of a fleet's robots, compared cell by cell with the state of the fleet."""

import numpy as np
import pytest
from helpers.fleet_truth import charged_layout

from warehouse_core import Cell, FleetEnv
from warehouse_core.world.tiles import CELL_CODES, NO_STATIONS


def seen_by(fleet: FleetEnv, robot: int) -> list[str]:
    """Return the window of a robot."""
    (row, col), radius = fleet.cells[robot], fleet.settings.view_radius
    side = range(-radius, radius + 1)
    return ["".join(tile_of(fleet, robot, (row + r, col + c)) for c in side) for r in side]


def tile_of(fleet: FleetEnv, robot: int, cell: Cell) -> str:
    if cell == fleet.cells[robot]:
        return "r" if fleet.loaded[robot] else "R"
    row, col = cell
    if not (0 <= row < fleet.layout.height and 0 <= col < fleet.layout.width):
        return "#"
    tile, mine, orders = fleet.layout.rows[row][col], fleet.order_of[robot], fleet.orders
    tiles = {tile if tile == "C" or not fleet.settings.has_orders else tile.translate(NO_STATIONS)}
    tiles |= {"P" for order in fleet.open_orders if orders[order].pickup == cell}
    if mine is not None:
        tiles |= {"P"} if not fleet.loaded[robot] and orders[mine].pickup == cell else set()
        tiles |= {"D"} if orders[mine].dropoff == cell else set()
    others = zip(fleet.cells, fleet.loaded, strict=True)
    tiles |= {"o" if loaded else "O" for at, loaded in others if at == cell}
    tiles |= {"H" for at in fleet.people if at == cell}
    return max(tiles, key=CELL_CODES.__getitem__)


@pytest.mark.parametrize(("radius", "orders"), [(4, None), (1, 0.15)])
def test_windows_show_what_is_there_and_nothing_else(radius: int, orders: float | None) -> None:
    """With few orders, most robots have none, including robots next to the edge."""
    stream, tiles = np.random.default_rng(radius), set[str]()
    for robots in (1, 4):
        fleet = FleetEnv(
            charged_layout(6, 7, 2, seed=radius), robots, orders=orders, people=1, battery=10**6,
            view_radius=radius, max_steps=100,
        )  # fmt: skip
        _, info = fleet.reset(seed=radius)
        while not all(fleet.ended):
            windows = [each["local_grid"] for each in fleet.observations()]
            assert windows == [seen_by(fleet, robot) for robot in range(robots)]
            tiles |= set("".join(windows[-1]))
            masks = info["action_mask"] * np.array([1, 1, 1, 1, 1, 20, 20])
            *_, info = fleet.step((stream.random(masks.shape) * masks).argmax(axis=1))
    assert tiles >= set("#.PDCRrOoH")
