"""The fields of an ``Episode`` as arrays, and back: the content of a ``.npz`` file.

``T`` is the number of steps and ``F = T + 1`` of frames, ``R`` of robots, ``P`` of people and ``K``
of orders. Words are stored as codes; the words themselves and all other values are in ``header``,
which is JSON text. The outcomes of all bodies are concatenated, step by step, and so are their
paths and contacts. The record of a lone robot has no axis for the robots.

A file is not trusted: nothing is read before its size is known, and what does not fit together is
refused.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Hashable, Iterable, Sequence
from dataclasses import asdict, astuple
from itertools import chain
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from warehouse_core.batch.fleet.settings import FleetSettings
from warehouse_core.batch.fleet.tally import FleetMeasures
from warehouse_core.errors import RecordError
from warehouse_core.files.header import pack_header, unpack_header
from warehouse_core.files.npz import Arrays, Schema
from warehouse_core.motion.base import Contact, Outcome
from warehouse_core.motion.vector import WALL
from warehouse_core.orders.order import Order
from warehouse_core.task.settings import Settings, conditions_in
from warehouse_core.world.actions import INVALID
from warehouse_core.world.layout import MAX_CELLS, Layout, check_size

LONE_FORMAT, FLEET_FORMAT = "warehouse-lab episode 1", "warehouse-lab fleet episode 1"

MAX_NUMBER = 1e12
"""Limit on the size of a reward, time, energy, impulse or coordinate, so that sums are finite."""

NONE = -1
"""Number that stands for ``None`` in the arrays of orders and assignments."""

ORDER_COLUMNS = 10
"""Number of columns of an order: the fields of ``Order``, with two for each of its cells."""

MOTION_SCHEMA: Schema = {
    "motion_cells": ("<i4", 2),
    "motion_blocked": ("|b1", 1),
    "motion_seconds": ("<f8", 1),
    "motion_joules": ("<f8", 1),
    "path": ("<f8", 2),
    "path_lengths": ("<i4", 1),
    "contacts": ("<f8", 2),
    "contact_counts": ("<i4", 1),
    "contact_counterparts": ("<i4", 1),
}

LONE_SCHEMA: Schema = {
    "header": ("|u1", 1),
    "layout": ("|u1", 2),
    "cells": ("<i4", 2),
    "loaded": ("|b1", 1),
    "battery": ("<i8", 1),
    "rewards": ("<f8", 1),
    "actions": ("<i4", 1),
    "reasons": ("<i4", 1),
    **MOTION_SCHEMA,
}

FRAME_COLUMNS = {"cells": "<i4", "loaded": "|b1", "battery": "<f8", "people": "<i4"}
"""Arrays ``[F, R]`` of a fleet; people are ``[F, P]``."""

STEP_COLUMNS = {
    "rewards": "<f8", "actions": "|i1", "stopped_by": "<i4", "seconds": "<f8", "joules": "<f8",
}  # fmt: skip
"""Arrays ``[T, R]`` of a fleet."""

END_COLUMNS = {"terminated": "|b1", "truncated": "|b1"}
"""Arrays ``[R]`` of a fleet."""

FLEET_SCHEMA: Schema = {
    "header": ("|u1", 1),
    "layout": ("|u1", 2),
    "orders": ("<i4", 2),
    "assignments": ("<i4", 2),
    **{name: (dtype, 2) for name, dtype in (FRAME_COLUMNS | STEP_COLUMNS).items()},
    **{name: (dtype, 1) for name, dtype in END_COLUMNS.items()},
    **MOTION_SCHEMA,
}

SCHEMAS: tuple[Schema, ...] = (
    LONE_SCHEMA,
    FLEET_SCHEMA,
    {**FLEET_SCHEMA, "reasons": ("<i4", 2)},
)
"""Schemas of files: a lone robot, and a fleet without and with the reasons of its agent."""

FIELD_OF = {"seconds": "step_seconds", "joules": "step_joules"}
"""Fields of ``Episode`` whose arrays have another name."""

SCALARS: dict[str, dict[str, tuple[type, ...]]] = {
    LONE_FORMAT: {
        "seed": (int, type(None)), "agent": (str,), "terminated": (bool,), "truncated": (bool,),
    },
    FLEET_FORMAT: {"backend": (str,), "cell_size": (float,), "seed": (int,), "agent": (str,)},
}  # fmt: skip
"""Types of fields that are in the header, by format."""

WORDS: dict[str, set[type]] = {"actions": {str, int}, "reasons": {str}, "counterparts": {str}}
"""Types of words in the vocabularies of the header; a fleet has no vocabulary of actions."""

Fields = dict[str, Any]
"""Fields of an ``Episode`` by name."""

Word = TypeVar("Word", bound=Hashable)


def is_equal(one: object, other: object) -> bool:
    """Return whether two values of a field are equal; NaN in arrays and measures equals NaN."""
    if isinstance(one, FleetMeasures) and isinstance(other, FleetMeasures):
        one, other = np.array(astuple(one)), np.array(astuple(other))
    if isinstance(one, np.ndarray) and isinstance(other, np.ndarray):
        return one.dtype == other.dtype and np.array_equal(one, other, equal_nan=True)
    return one == other


def schema_of(arrays: Arrays) -> Schema:
    """Return the schema that has these arrays."""
    return next(schema for schema in SCHEMAS if schema.keys() == arrays.keys())


def pack(fields: Fields) -> Arrays:
    """Return the arrays of an episode, in the types of their schema.

    Raises:
        RecordError: a value has no place in its array.
        ValueError: the fields are those of no episode; also ``TypeError``, ``AttributeError`` or
            ``OverflowError``.
    """
    pack_rest = _pack_fleet if isinstance(fields["settings"], FleetSettings) else _pack_lone
    packed = {"layout": pack_layout(fields["layout"]), **pack_rest(fields)}
    return {
        name: _typed(name, packed[name], dtype, dimensions)
        for name, (dtype, dimensions) in schema_of(packed).items()
    }


def unpack(arrays: Arrays) -> Fields:
    """Undo ``pack``, checking that the fields fit together.

    Raises:
        ValueError: they do not; it may be a ``RecordError`` or a ``LayoutError``.
    """
    return (_unpack_fleet if "orders" in arrays else _unpack_lone)(arrays)


def _typed(name: str, array: NDArray[Any], dtype: str, dimensions: int) -> NDArray[Any]:
    """Return an array in the type of the schema, which must not change its values."""
    if array.dtype.kind in "biuf" and array.ndim == dimensions:
        with np.errstate(all="ignore"):
            typed = array.astype(dtype)
        if np.array_equal(typed, array, equal_nan=True):
            return typed
    raise RecordError(f"{name} cannot be stored as {np.dtype(dtype)} with {dimensions} dimensions")


def _pack_lone(fields: Fields) -> Arrays:
    action_words, actions = encode_words(fields["actions"])
    reason_words, reasons = encode_words(fields["reasons"])
    motion_arrays, about_motions = pack_motions(fields["motions"])
    header = {
        "format": LONE_FORMAT,
        "settings": asdict(fields["settings"]),
        "actions": action_words,
        "reasons": reason_words,
        **about_motions,
        **{name: fields[name] for name in SCALARS[LONE_FORMAT]},
    }
    return {
        "header": pack_header(header),
        "actions": actions,
        "reasons": reasons,
        **{name: np.array(fields[name]) for name in ("cells", "loaded", "battery", "rewards")},
        **motion_arrays,
    }


def _unpack_lone(arrays: Arrays) -> Fields:
    steps = len(arrays["actions"])
    header, layout = _read_header(arrays, LONE_FORMAT), unpack_layout(arrays["layout"])
    settings = Settings.from_json(header["settings"])
    expected = dict.fromkeys(("loaded", "battery", "rewards"), (steps + 1,))
    _check_shapes(arrays, {"cells": (steps + 1, 2), **expected, "reasons": (steps,)})
    check_numbers(arrays, "rewards")
    cells = [(row, col) for row, col in arrays["cells"].tolist()]
    for cell in (settings.start_pos, *cells):
        if not layout.is_open(cell):
            raise RecordError(f"no robot can be where {layout.describe(cell)}")
    check_slippery(layout, settings.slippery)
    motions = unpack_motions(arrays, header, steps)
    if [motion.cell for motion in motions] != cells[1:]:
        raise RecordError("the motions end in other cells than the robot was in")
    return {
        "layout": layout,
        "settings": settings,
        "cells": cells,
        "actions": decode_words(header["actions"], arrays["actions"], "actions"),
        "reasons": decode_words(header["reasons"], arrays["reasons"], "reasons"),
        "motions": motions,
        **{name: arrays[name].tolist() for name in expected},
        **{name: header[name] for name in SCALARS[LONE_FORMAT]},
    }


def _pack_fleet(fields: Fields) -> Arrays:
    measures = vars(fields["measures"])
    motion_arrays, about_motions = pack_motions([*chain.from_iterable(fields["motions"])])
    header = {
        "format": FLEET_FORMAT,
        "settings": fields["settings"].to_json(),
        "measures": {name: None if math.isnan(x) else x for name, x in measures.items()},
        **about_motions,
        **{name: fields[name] for name in SCALARS[FLEET_FORMAT]},
        "slippery": fields["slippery"],
        "motor_strength": fields["motor_strength"],
    }
    columns = (*FRAME_COLUMNS, *STEP_COLUMNS, *END_COLUMNS)
    arrays = {
        "orders": np.array([*map(_numbers, fields["orders"])]).reshape(-1, ORDER_COLUMNS),
        "assignments": np.array([*map(_without_none, fields["assignments"])]).reshape(-1, 3),
        **{name: fields[FIELD_OF.get(name, name)] for name in columns},
        **motion_arrays,
    }
    if fields["unknown_actions"]:
        given = fields["unknown_actions"].items()
        header["unknown_actions"] = [(*place, action) for place, action in given]
    if fields["reasons"]:
        header["reasons"], codes = encode_words([*chain.from_iterable(fields["reasons"])])
        arrays["reasons"] = codes.reshape(len(fields["reasons"]), -1)
    return arrays | {"header": pack_header(header)}


def _unpack_fleet(arrays: Arrays) -> Fields:
    header, layout = _read_header(arrays, FLEET_FORMAT), unpack_layout(arrays["layout"])
    if header["seed"] < 0 or not 0 < header["cell_size"] < np.inf:
        raise RecordError(
            f"seed is {header['seed']} and cell_size {header['cell_size']}; the first must be at "
            "least 0, the second positive and finite"
        )
    settings = FleetSettings.from_json(header["settings"])
    _check_fleet_shapes(arrays, settings)
    _check_values(arrays, layout, settings)
    _check_orders(arrays["orders"], layout, settings.robots, len(arrays["actions"]))
    conditions = conditions_in(header)
    check_slippery(layout, conditions["slippery"])
    columns = (*FRAME_COLUMNS, *STEP_COLUMNS, *END_COLUMNS)
    return {
        "layout": layout,
        "settings": settings,
        "orders": [_order(numbers) for numbers in arrays["orders"].tolist()],
        "assignments": [tuple(_with_none(each)) for each in arrays["assignments"].tolist()],
        "reasons": _read_reasons(arrays, header),
        "unknown_actions": _read_unknown_actions(arrays, header),
        "motions": _read_fleet_motions(arrays, header, layout, settings.bodies),
        "measures": _read_measures(header.get("measures")),
        **conditions,
        **{FIELD_OF.get(name, name): arrays[name] for name in columns},
        **{name: header[name] for name in SCALARS[FLEET_FORMAT]},
    }


def _read_header(arrays: Arrays, form: str) -> dict[str, Any]:
    header = unpack_header(arrays["header"], form)
    for name, types in SCALARS[form].items():
        if type(header.get(name, Any)) not in types:
            raise RecordError(f"{name} is {header.get(name)!r}; it must be {types[0].__name__}")
    unused = {"actions"} if form == FLEET_FORMAT else set()
    for name in (WORDS.keys() & {"counterparts", *arrays}) - unused:
        words = header.get(name)
        if not isinstance(words, list) or not {type(word) for word in words} <= WORDS[name]:
            raise RecordError(f"{name} must be a list of words")
    return {"settings": None} | header


def _read_reasons(arrays: Arrays, header: dict[str, Any]) -> list[tuple[str, ...]]:
    """Return the reasons of each step; older records have none."""
    if "reasons" not in arrays:
        return []
    codes = arrays["reasons"]
    words = decode_words(header["reasons"], codes.ravel(), "reasons")
    robots = codes.shape[1]
    return [tuple(words[first : first + robots]) for first in range(0, len(words), robots)]


def _read_unknown_actions(
    arrays: Arrays, header: dict[str, Any]
) -> dict[tuple[int, int], str | int]:
    """Return the actions that are not allowed, as given; older records have none."""
    entries, unknown = header.get("unknown_actions", []), arrays["actions"] == INVALID
    steps, robots = unknown.shape
    if not isinstance(entries, list) or not all(
        isinstance(entry, list)
        and [type(part) for part in entry] in ([int, int, str], [int, int, int])
        and 0 <= entry[0] < steps
        and 0 <= entry[1] < robots
        and unknown[entry[0], entry[1]]
        for entry in entries
    ):
        raise RecordError("unknown_actions must be lists of a step, a robot and its action")
    return {(step, robot): action for step, robot, action in entries}


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


def _check_fleet_shapes(arrays: Arrays, settings: FleetSettings) -> None:
    steps, robots = len(arrays["actions"]), settings.robots
    expected: dict[str, tuple[int, ...]] = {
        **dict.fromkeys(FRAME_COLUMNS, (steps + 1, robots)),
        "people": (steps + 1, settings.people.count),
        **dict.fromkeys(STEP_COLUMNS, (steps, robots)),
        **dict.fromkeys(END_COLUMNS, (robots,)),
        "orders": (len(arrays["orders"]), ORDER_COLUMNS),
        "assignments": (len(arrays["assignments"]), 3),
    }
    _check_shapes(arrays, expected | ({"reasons": (steps, robots)} if "reasons" in arrays else {}))


def _check_shapes(arrays: Arrays, expected: dict[str, tuple[int, ...]]) -> None:
    for name, shape in expected.items():
        if arrays[name].shape != shape:
            raise RecordError(f"{name} has the shape {arrays[name].shape}; it must be {shape}")


def _check_values(arrays: Arrays, layout: Layout, settings: FleetSettings) -> None:
    check_numbers(arrays, "rewards", "battery", "seconds", "joules")
    _check_costs(arrays["seconds"], arrays["joules"])
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


def check_slippery(layout: Layout, cells: Iterable[tuple[int, int]]) -> None:
    """Raise ``RecordError`` unless these cells are open."""
    for cell in cells:
        if not layout.is_open(cell):
            raise RecordError(f"no floor is slippery where {layout.describe(cell)}")


def pack_layout(layout: Layout) -> NDArray[np.uint8]:
    """Return the characters of a layout as bytes, ``[H, W]``."""
    tiles = np.frombuffer("".join(layout.rows).encode("ascii"), dtype=np.uint8)
    return tiles.reshape(layout.height, layout.width)


def unpack_layout(tiles: NDArray[np.uint8]) -> Layout:
    """Undo ``pack_layout``.

    Raises:
        ValueError: no layout has these tiles; it may be a ``RecordError`` or a ``LayoutError``.
    """
    # Checked first: rows without columns take no room in a file, but could be very many.
    if not 0 < tiles.size <= MAX_CELLS:
        raise RecordError(f"layout: {tiles.shape} tiles; there must be 1..{MAX_CELLS}")
    check_size(*tiles.shape)
    return Layout([row.tobytes().decode("ascii") for row in tiles])


def check_numbers(arrays: Arrays, *names: str) -> None:
    """Raise if one of these arrays has a number beyond ``MAX_NUMBER``, or NaN."""
    for name in names:
        if not (np.abs(arrays[name]) <= MAX_NUMBER).all():  # NaN neither
            raise RecordError(f"{name} has a number outside {-MAX_NUMBER:g}..{MAX_NUMBER:g}")


def _check_costs(seconds: NDArray[Any], joules: NDArray[Any]) -> None:
    if seconds.min(initial=1) <= 0 or joules.min(initial=0) < 0:
        raise RecordError("a motion took no time, or less than no energy")


def encode_words(words: Iterable[Word]) -> tuple[list[Word], NDArray[np.int32]]:
    """Return the different words and, for each of ``words``, its index among them."""
    codes: dict[Word, int] = {}
    indices = [codes.setdefault(word, len(codes)) for word in words]
    return list(codes), np.array(indices, dtype=np.int32)


def decode_words(vocabulary: Sequence[Word], codes: NDArray[Any], name: str) -> list[Word]:
    """Undo ``encode_words``.

    Raises:
        RecordError: a code beyond the vocabulary.
    """
    if codes.size and not (codes.min() >= 0 and codes.max() < len(vocabulary)):
        raise RecordError(f"{name} has a code outside 0..{len(vocabulary) - 1}")
    return [vocabulary[code] for code in codes.tolist()]


def pack_motions(motions: Collection[Outcome]) -> tuple[Arrays, dict[str, Any]]:
    """Return the arrays of ``MOTION_SCHEMA``, and what the header says about them."""
    contacts = [contact for motion in motions for contact in motion.contacts]
    counterparts, codes = encode_words(contact.counterpart for contact in contacts)
    arrays: Arrays = {
        "motion_cells": np.array([motion.cell for motion in motions]).reshape(-1, 2),
        "motion_blocked": np.array([motion.blocked for motion in motions]),
        "motion_seconds": np.array([motion.seconds for motion in motions]),
        "motion_joules": np.array([motion.joules for motion in motions]),
        "path": np.concatenate([np.empty((0, 4)), *(motion.path for motion in motions)]),
        "path_lengths": np.array([len(motion.path) for motion in motions]),
        "contacts": np.array(
            [(contact.seconds, contact.impulse, *contact.point) for contact in contacts]
        ).reshape(-1, 4),
        "contact_counts": np.array([len(motion.contacts) for motion in motions]),
        "contact_counterparts": codes,
    }
    cut_off = [number for number, motion in enumerate(motions) if motion.cut_off]
    return arrays, {"counterparts": counterparts} | ({"cut_off": cut_off} if cut_off else {})


def unpack_motions(arrays: Arrays, header: dict[str, Any], count: int) -> list[Outcome]:
    """Undo ``pack_motions``, checking that the arrays fit together.

    Raises:
        RecordError: they do not, or a value is impossible.
    """
    _check_motions(arrays, count)
    cut_off = header.get("cut_off", [])
    if not isinstance(cut_off, list) or not all(
        type(number) is int and 0 <= number < count for number in cut_off
    ):
        raise RecordError(f"cut_off must be a list of motions from 0 to {count - 1}")
    codes = arrays["contact_counterparts"]
    names = decode_words(header["counterparts"], codes, "contact_counterparts")
    contacts = [
        Contact(seconds, impulse, (x, y), name)
        for (seconds, impulse, x, y), name in zip(arrays["contacts"].tolist(), names, strict=True)
    ]
    paths = np.split(arrays["path"], np.cumsum(arrays["path_lengths"])[:-1]) if count else []
    ends = np.cumsum(arrays["contact_counts"]).tolist()
    rows = zip(
        arrays["motion_cells"].tolist(),
        arrays["motion_blocked"].tolist(),
        arrays["motion_seconds"].tolist(),
        arrays["motion_joules"].tolist(),
        paths,
        [0, *ends],
        ends,
        strict=False,
    )
    motions = [
        Outcome((row, col), blocked, seconds, joules, path, tuple(contacts[start:end]))
        for (row, col), blocked, seconds, joules, path, start, end in rows
    ]
    for number in cut_off:
        motions[number] = motions[number]._replace(cut_off=True)
    return motions


def _check_motions(arrays: Arrays, count: int) -> None:
    contacts = int(arrays["contact_counts"].sum(dtype=np.int64))
    each_motion = (
        "motion_cells", "motion_blocked", "motion_seconds", "motion_joules",
        "path_lengths", "contact_counts",
    )  # fmt: skip
    columns = {"path": 4, "contacts": 4, "motion_cells": 2}
    sizes = {
        **{name: (len(arrays[name]), count) for name in each_motion},
        **{f"{name} columns": (arrays[name].shape[1], width) for name, width in columns.items()},
        "path": (len(arrays["path"]), int(arrays["path_lengths"].sum(dtype=np.int64))),
        "contacts": (len(arrays["contacts"]), contacts),
        "contact_counterparts": (len(arrays["contact_counterparts"]), contacts),
    }
    for name, (size, expected) in sizes.items():
        if size != expected:
            raise RecordError(f"{name}: {size}; there must be {expected}")
    if count and (arrays["path_lengths"].min() < 2 or arrays["contact_counts"].min() < 0):
        raise RecordError("a path has fewer than two rows, or a count is negative")
    check_numbers(arrays, "motion_seconds", "motion_joules", "path", "contacts")
    _check_costs(arrays["motion_seconds"], arrays["motion_joules"])


def _read_fleet_motions(
    arrays: Arrays, header: dict[str, Any], layout: Layout, bodies: int
) -> list[tuple[Any, ...]]:
    steps = len(arrays["actions"]) if len(arrays["motion_cells"]) else 0
    motions = unpack_motions(arrays, header, steps * bodies)
    ends = np.hstack([arrays["cells"], arrays["people"]])[1 : steps + 1]
    cells = arrays["motion_cells"].astype(np.int64) @ [layout.width, 1]
    if not np.array_equal(cells, ends.ravel()):
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
