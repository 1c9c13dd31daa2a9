"""Files of orders as comma-separated values with a header line.

The columns are ``released``, ``due``, ``pickup_row``, ``pickup_col``, ``dropoff_row``,
``dropoff_col`` and ``robot``, which is empty for an open order. Errors count lines from 1.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from warehouse_core.errors import LayoutError, OrderError
from warehouse_core.files.atomic import atomic_path
from warehouse_core.orders.order import MAX_ORDERS, Order
from warehouse_core.world.text_lines import (
    error_at,
    expect_line,
    opened,
    read_line,
    read_lines,
    whole_number_at,
)

COLUMNS = (
    "released", "due", "pickup_row", "pickup_col", "dropoff_row", "dropoff_col", "robot"
)  # fmt: skip


def load_orders(path: str | Path) -> list[Order]:
    """Return the orders in a file.

    Raises:
        OrderError: the file has a different format, or more than ``MAX_ORDERS`` lines; the message
            names file, line and column.
        OSError: the file cannot be read.

    Example:
        >>> from warehouse_core import Order
        >>> from warehouse_core.orders import load_orders, save_orders
        >>> save_orders("orders.csv", [Order(0, 50, (1, 3), (5, 6))])
        >>> len(load_orders("orders.csv"))
        1
    """
    try:
        with opened(path) as file:
            expect_line(read_line(file, 1), 1, ",".join(COLUMNS))
            lines = read_lines(file, 2, "MAX_ORDERS", MAX_ORDERS)
            return [_order(line, number) for number, line in lines]
    except LayoutError as error:
        raise OrderError(str(error)) from error


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
    lines = [",".join(COLUMNS)]
    for order in orders:
        cells = *order.pickup, *order.dropoff
        robot = "" if order.robot is None else order.robot
        lines.append(",".join(map(str, (order.released, order.due, *cells, robot))))
    with atomic_path(path) as part:
        part.write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")


def _order(line: str, number: int) -> Order:
    fields = line.split(",")
    if len(fields) != len(COLUMNS):
        message = f"{len(fields)} columns where there must be {len(COLUMNS)}: {', '.join(COLUMNS)}"
        raise error_at(number, min(len(fields), len(COLUMNS) + 1), message)
    values = [
        whole_number_at(text.strip(), name, 0, number, column)
        for column, (text, name) in enumerate(zip(fields, COLUMNS, strict=True), 1)
        if text.strip() or name != "robot"
    ]
    released, due, *cells = values[:6]
    robot = values[6] if len(values) > 6 else None
    return Order(released, due, (cells[0], cells[1]), (cells[2], cells[3]), robot)
