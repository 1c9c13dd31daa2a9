"""The fields of a fleet's episode as arrays, and back: the content of a ``.npz`` file.

``T`` is the number of steps and ``F = T + 1`` of frames, ``R`` of robots, ``P`` of people and ``K``
of orders; see ``episode_arrays.py``. The outcomes of all bodies are concatenated, step by step.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import astuple
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warehouse_core.batch.fleet.settings import FleetSettings
from warehouse_core.batch.fleet.tally import FleetMeasures
from warehouse_core.errors import RecordError
from warehouse_core.files.npz import Arrays, Schema
from warehouse_core.motion.vector import WALL
from warehouse_core.orders.order import Order
from warehouse_core.records.episode_arrays import (
    MOTION_SCHEMA,
    Fields,
    check_numbers,
    check_slippery,
    pack_header,
    pack_layout,
    pack_motions,
    unpack_header,
    unpack_layout,
    unpack_motions,
)
from warehouse_core.task.settings import conditions_in
from warehouse_core.world.actions import INVALID
from warehouse_core.world.layout import Layout

FORMAT = "warehouse-lab fleet episode 1"

FRAME_COLUMNS = {"cells": "<i4", "loaded": "|b1", "battery": "<f8", "people": "<i4"}
"""Arrays ``[F, R]``, the last one ``[F, P]``."""

STEP_COLUMNS = {
    "rewards": "<f8", "actions": "|i1", "stopped_by": "<i4", "seconds": "<f8", "joules": "<f8",
}  # fmt: skip
"""Arrays ``[T, R]``."""

END_COLUMNS = {"terminated": "|b1", "truncated": "|b1"}
"""Arrays ``[R]``."""

FLEET_SCHEMA: Schema = {
    "header": ("|u1", 1),
    "layout": ("|u1", 2),
    "orders": ("<i4", 2),
    "assignments": ("<i4", 2),
    **{name: (dtype, 2) for name, dtype in (FRAME_COLUMNS | STEP_COLUMNS).items()},
    **{name: (dtype, 1) for name, dtype in END_COLUMNS.items()},
    **MOTION_SCHEMA,
}

HEADER_TYPES = {"backend": str, "cell_size": float, "seed": int, "agent": str}

NONE = -1
"""In the arrays of orders and assignments, in place of ``None``."""

ORDER_COLUMNS = 10
"""Of an order: the fields of ``Order``, and of its cells row and column."""


def is_equal(one: object, other: object) -> bool:
    """Return whether two values of a field are equal; NaN equals NaN."""
    if isinstance(one, FleetMeasures) and isinstance(other, FleetMeasures):
        one, other = np.array(astuple(one)), np.array(astuple(other))
    if isinstance(one, np.ndarray) and isinstance(other, np.ndarray):
        return one.dtype == other.dtype and np.array_equal(one, other, equal_nan=True)
    return one == other


def pack(fields: Fields) -> Arrays:
    """Return arrays for ``FLEET_SCHEMA``, not yet of its types."""
    measures = vars(fields["measures"])
    motion_arrays, counterparts = pack_motions([*chain.from_iterable(fields["motions"])])
    header = {
        "format": FORMAT,
        "settings": fields["settings"].to_json(),
        "measures": {name: None if math.isnan(x) else x for name, x in measures.items()},
        "counterparts": counterparts,
    } | {name: fields[name] for name in (*HEADER_TYPES, "slippery", "motor_strength")}
    return {
        "header": pack_header(header),
        "layout": pack_layout(fields["layout"]),
        "orders": np.array([*map(_numbers, fields["orders"])]).reshape(-1, ORDER_COLUMNS),
        "assignments": np.array([*map(_without_none, fields["assignments"])]).reshape(-1, 3),
        **{name: fields[name] for name in (*FRAME_COLUMNS, *STEP_COLUMNS, *END_COLUMNS)},
        **motion_arrays,
    }


def unpack(arrays: Arrays) -> Fields:
    """Undo ``pack``, checking that the fields fit together.

    Raises:
        ValueError: they do not; it may be a ``RecordError`` or a ``LayoutError``.
    """
    header = _read_header(arrays)
    settings, layout = FleetSettings.from_json(header["settings"]), unpack_layout(arrays["layout"])
    steps = len(arrays["actions"])
    _check_shapes(arrays, settings, steps)
    _check_values(arrays, layout, settings)
    _check_orders(arrays["orders"], layout, settings.robots, steps)
    fields: Fields = {name: header[name] for name in HEADER_TYPES}
    fields |= {name: arrays[name] for name in (*FRAME_COLUMNS, *STEP_COLUMNS, *END_COLUMNS)}
    fields |= conditions_in(header)
    check_slippery(layout, fields["slippery"])
    return fields | {
        "layout": layout,
        "settings": settings,
        "orders": [_order(numbers) for numbers in arrays["orders"].tolist()],
        "assignments": [tuple(_with_none(each)) for each in arrays["assignments"].tolist()],
        "motions": _read_motions(arrays, header["counterparts"], layout, settings.bodies),
        "measures": _read_measures(header["measures"]),
    }


def _read_header(arrays: Arrays) -> dict[str, Any]:
    header = unpack_header(arrays["header"], FORMAT)
    for name, kind in HEADER_TYPES.items():
        if type(header.get(name)) is not kind:
            raise RecordError(f"{name} is {header.get(name)!r}; it must be {kind.__name__}")
    if header["seed"] < 0 or not 0 < header["cell_size"] < np.inf:
        raise RecordError(
            f"seed is {header['seed']} and cell_size {header['cell_size']}; the first must be at "
            "least 0, the second positive and finite"
        )
    words = header.get("counterparts")
    if not isinstance(words, list) or not {type(word) for word in words} <= {str}:
        raise RecordError("counterparts must be a list of words")
    return {"settings": None, "measures": None} | header


def _read_measures(values: Any) -> FleetMeasures:
    kinds = FleetMeasures.__annotations__
    if isinstance(values, dict):  # older records have no lost items
        values = {"lost": 0} | values
    if not isinstance(values, dict) or values.keys() != kinds.keys():
        raise RecordError(f"measures must have the keys {', '.join(kinds)}")
    for name, value in values.items():
        is_whole = kinds[name] == "int"
        if not (type(value) is int if is_whole else type(value) is float or value is None):
            raise RecordError(f"{name} is {value!r}; it must be {kinds[name]}")
    numbers: dict[str, Any] = {name: math.nan if x is None else x for name, x in values.items()}
    return FleetMeasures(**numbers)


def _check_shapes(arrays: Arrays, settings: FleetSettings, steps: int) -> None:
    robots, people = settings.robots, settings.people.count
    expected: dict[str, tuple[int, ...]] = {
        **dict.fromkeys(FRAME_COLUMNS, (steps + 1, robots)),
        "people": (steps + 1, people),
        **dict.fromkeys(STEP_COLUMNS, (steps, robots)),
        **dict.fromkeys(END_COLUMNS, (robots,)),
        "orders": (len(arrays["orders"]), ORDER_COLUMNS),
        "assignments": (len(arrays["assignments"]), 3),
    }
    for name, shape in expected.items():
        if arrays[name].shape != shape:
            raise RecordError(f"{name} has the shape {arrays[name].shape}; it must be {shape}")


def _check_values(arrays: Arrays, layout: Layout, settings: FleetSettings) -> None:
    check_numbers(arrays, "rewards", "battery", "seconds", "joules")
    if arrays["seconds"].min(initial=1) <= 0 or arrays["joules"].min(initial=0) < 0:
        raise RecordError("a motion took no time, or less than no energy")
    last = layout.height * layout.width - 1
    assigned = arrays["assignments"]
    for name, numbers, low, high in (
        ("cells", arrays["cells"], 0, last),
        ("people", arrays["people"], 0, last),
        ("actions", arrays["actions"], 0, INVALID),
        ("stopped_by", arrays["stopped_by"], WALL, settings.bodies - 1),
        ("steps of assignments", assigned[:, 0], 0, len(arrays["actions"])),
        ("robots of assignments", assigned[:, 1], 0, settings.robots - 1),
        ("orders of assignments", assigned[:, 2], NONE, len(arrays["orders"]) - 1),
    ):
        if not ((numbers >= low) & (numbers <= high)).all():
            raise RecordError(f"{name}: a number is outside {low}..{high}")
    for name in ("cells", "people"):
        _check_open(name, arrays[name], layout)


def _check_open(name: str, cells: NDArray[Any], layout: Layout) -> None:
    """Raise if one of the cells is a wall."""
    closed = np.setdiff1d(cells, layout.open_cells)
    if len(closed):
        raise RecordError(f"{name}: {layout.describe(divmod(int(closed[0]), layout.width))}")


def _check_orders(orders: NDArray[Any], layout: Layout, robots: int, steps: int) -> None:
    released, due, *cells, robot, taken_by, taken, delivered = orders.T
    for name, (rows, cols) in (("pickup", cells[:2]), ("dropoff", cells[2:])):
        inside = (rows >= 0) & (rows < layout.height) & (cols >= 0) & (cols < layout.width)
        if not inside.all():
            raise RecordError(f"an order has a {name} off the grid")
        _check_open(f"an order's {name}", rows * layout.width + cols, layout)
    was_taken, was_delivered = taken != NONE, delivered != NONE
    rules = {
        "released before step 0 or after the last, or due before": (
            (released >= 0) & (released <= steps) & (due >= released)
        ),
        "for or taken by a robot that does not exist": (
            (np.minimum(robot, taken_by) >= NONE) & (np.maximum(robot, taken_by) < robots)
        ),
        "taken before it was released, after the last step, or by nobody": (
            (was_taken == (taken_by != NONE))
            & (~was_taken | ((released <= taken) & (taken <= steps)))
        ),
        "delivered before it was taken, or after the last step": (
            ~was_delivered | (was_taken & (taken <= delivered) & (delivered <= steps))
        ),
    }
    for problem, is_right in rules.items():
        if not is_right.all():
            raise RecordError(f"order {int(np.argmin(is_right))} is {problem}")


def _read_motions(
    arrays: Arrays, counterparts: list[str], layout: Layout, bodies: int
) -> list[tuple[Any, ...]]:
    steps = len(arrays["actions"]) if len(arrays["motion_cells"]) else 0
    motions = unpack_motions(arrays, counterparts, steps * bodies)
    ends = np.hstack([arrays["cells"], arrays["people"]])[1 : steps + 1]
    found = arrays["motion_cells"].astype(np.int64) @ [layout.width, 1]
    if not np.array_equal(found, ends.ravel()):
        raise RecordError("the motions end in other cells than robots and people were in")
    return [tuple(motions[first : first + bodies]) for first in range(0, len(motions), bodies)]


def _numbers(order: Order) -> list[int]:
    released, due, pickup, dropoff, *rest = order
    return [released, due, *pickup, *dropoff, *_without_none(rest)]


def _order(numbers: list[int]) -> Order:
    released, due, row, col, to_row, to_col, *rest = numbers
    return Order(released, due, (row, col), (to_row, to_col), *_with_none(rest))


def _without_none(values: Iterable[int | None]) -> list[int]:
    return [NONE if value is None else value for value in values]


def _with_none(values: Iterable[int]) -> list[int | None]:
    return [None if value == NONE else value for value in values]
