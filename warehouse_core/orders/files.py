"""Files of orders as comma-separated values with a header line.

The columns are ``released``, ``due``, ``pickup_row``, ``pickup_col``, ``dropoff_row``,
``dropoff_col`` and ``robot``, which is empty for an open order.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import islice
from pathlib import Path

from warehouse_core.errors import OrderError
from warehouse_core.files.tables import read_table, whole_in, write_table
from warehouse_core.orders.order import MAX_ORDERS, Order

COLUMNS = (
    "released", "due", "pickup_row", "pickup_col", "dropoff_row", "dropoff_col", "robot"
)  # fmt: skip

MAX_BYTES = 64 * MAX_ORDERS
"""Limit on the bytes of a file."""


def load_orders(path: str | Path) -> list[Order]:
    """Return the orders in a file.

    Raises:
        OrderError: the file has a different format, or more than ``MAX_ORDERS`` orders; the
            message names the file and the line.
        OSError: the file cannot be read, or is longer than ``MAX_BYTES``.

    Example:
        >>> from warehouse_core import Order
        >>> from warehouse_core.orders import load_orders, save_orders
        >>> save_orders("orders.csv", [Order(0, 50, (1, 3), (5, 6))])
        >>> len(load_orders("orders.csv"))
        1
    """
    try:
        orders = list(islice(read_table(path, COLUMNS, MAX_BYTES, _order), MAX_ORDERS + 1))
    except ValueError as error:
        raise OrderError(f"{path}: {error}") from None
    if len(orders) > MAX_ORDERS:
        raise OrderError(f"{path}: more than MAX_ORDERS = {MAX_ORDERS} orders")
    return orders


def save_orders(path: str | Path, orders: Iterable[Order]) -> None:
    """Write orders to a file, atomically and without their progress.

    Raises:
        OSError: the file cannot be written.

    Example:
        >>> from pathlib import Path
        >>> from warehouse_core import Order
        >>> from warehouse_core.orders import save_orders
        >>> save_orders("orders.csv", [Order(0, 50, (1, 3), (5, 6))])
        >>> print(Path("orders.csv").read_text(), end="")
        released,due,pickup_row,pickup_col,dropoff_row,dropoff_col,robot
        0,50,1,3,5,6,
    """
    lines = ((each.released, each.due, *each.pickup, *each.dropoff, each.robot) for each in orders)
    write_table(path, COLUMNS, lines)


def _order(row: dict[str, str]) -> Order:
    released, due, *cells = (whole_in(row, name) for name in COLUMNS[:-1])
    robot = whole_in(row, COLUMNS[-1]) if row[COLUMNS[-1]] else None
    return Order(released, due, (cells[0], cells[1]), (cells[2], cells[3]), robot)
