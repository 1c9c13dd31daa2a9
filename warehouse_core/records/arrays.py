"""Conversion between an ``Episode`` and the arrays of its ``.npz`` file.

Words are stored as codes. The words themselves and all values that are not arrays are in
``header``, which is JSON text. The outcomes of all bodies are concatenated step by step, and so are
their paths and contacts. Files are not trusted: inconsistent content is refused.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterable, Sequence
from dataclasses import astuple
from itertools import chain, islice, repeat
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from warehouse_core.batch.fleet_settings import FleetSettings
from warehouse_core.batch.tally import FleetMeasures
from warehouse_core.errors import RecordError
from warehouse_core.files.json_text import pack_header, unpack_header
from warehouse_core.files.npz import Arrays, Schema
from warehouse_core.motion.base import WALL, Contact, Outcome
from warehouse_core.orders.order import Order
from warehouse_core.task.settings import Settings, conditions_in
from warehouse_core.wording import brief, listed
from warehouse_core.world.actions import INVALID, WAIT
from warehouse_core.world.layout import MAX_CELLS, Layout, check_size
from warehouse_core.world.tiles import Cell

MAX_NUMBER = 1e12
"""Limit on the size of a reward, time, energy, impulse or coordinate, so that sums are finite."""

MAX_OBJECTS = 500_000
"""Most objects of a record: steps of a single robot, motions, contacts, orders and assignments.

The limit is on their sum. Each object takes several hundred bytes of memory, but at most about one
byte of a compressed file, so a small file could otherwise exhaust the memory.
"""

NONE = -1
"""Number that stands for ``None`` in the arrays of orders and assignments."""

ColumnSpecs = dict[str, tuple[str, str]]
"""Type of each array, and its axes, one letter each; see ``LENGTHS`` and ``_lengths``."""

LENGTHS = {"2": 2, "3": 3, "4": 4, "5": 5, "O": 10}
"""Lengths of the axes that are the same in all records. ``O`` counts the numbers of an order: the
fields of ``Order``, with two numbers for each cell."""

MOTION_COLUMNS: ColumnSpecs = {
    "motion_cells": ("<i4", "M2"),
    "motion_blocked": ("|b1", "M"),
    "motion_seconds": ("<f8", "M"),
    "motion_joules": ("<f8", "M"),
    "path": ("<f8", "L4"),
    "path_lengths": ("<i4", "M"),
    "contacts": ("<f8", "C4"),
    "contact_counts": ("<i4", "M"),
    "contact_counterparts": ("<i4", "C"),
}

READ_COLUMNS: ColumnSpecs = {"readings": ("<f8", "L5")}
"""Columns that records have in addition if all their motions have readings."""

LINE_COLUMNS: ColumnSpecs = {"lines": ("<f8", "N5"), "line_counts": ("<i4", "M")}
"""Columns of a single robot in addition if all its motions have lines."""

LONE_COLUMNS: ColumnSpecs = {
    "header": ("|u1", "*"),
    "layout": ("|u1", "**"),
    "cells": ("<i4", "F2"),
    "loaded": ("|b1", "F"),
    "battery": ("<i8", "F"),
    "rewards": ("<f8", "F"),
    "actions": ("<i4", "T"),
    "reasons": ("<i4", "T"),
    **MOTION_COLUMNS,
}

FLEET_COLUMNS: ColumnSpecs = {
    "header": ("|u1", "*"),
    "layout": ("|u1", "**"),
    "orders": ("<i4", "*O"),
    "assignments": ("<i4", "*3"),
    "cells": ("<i4", "FR"),
    "loaded": ("|b1", "FR"),
    "battery": ("<f8", "FR"),
    "people": ("<i4", "FP"),
    "rewards": ("<f8", "TR"),
    "actions": ("|i1", "TR"),
    "stopped_by": ("<i4", "TR"),
    "seconds": ("<f8", "TR"),
    "joules": ("<f8", "TR"),
    "terminated": ("|b1", "R"),
    "truncated": ("|b1", "R"),
    **MOTION_COLUMNS,
}

REASONED_COLUMNS: ColumnSpecs = FLEET_COLUMNS | {"reasons": ("<i4", "TR")}
"""Columns of a fleet whose agent gave reasons."""

HEADED_COLUMNS: ColumnSpecs = REASONED_COLUMNS | {"headings": ("|i1", "FR")}
"""Columns of a fleet whose robots have headings. They always include reasons, possibly empty."""

FIELD_OF = {"seconds": "step_seconds", "joules": "step_joules"}
"""Field of ``Episode`` for each array that has a different name."""

LONE_FORMAT, FLEET_FORMAT = "warehouse-lab episode 1", "warehouse-lab fleet episode 1"

SCALARS: dict[str, dict[str, tuple[type, ...]]] = {
    LONE_FORMAT: {
        "seed": (int, type(None)), "agent": (str,), "terminated": (bool,), "truncated": (bool,),
    },
    FLEET_FORMAT: {"backend": (str,), "cell_size": (float,), "seed": (int,), "agent": (str,)},
}  # fmt: skip
"""Types of the fields that are stored in the header, by format."""

HEADER_KEYS = {
    LONE_FORMAT: (
        "settings", *SCALARS[LONE_FORMAT], "actions", "reasons", "counterparts", "cut_off",
    ),
    FLEET_FORMAT: (
        "settings", *SCALARS[FLEET_FORMAT], "measures", "slippery", "motor_strength", "drive",
        "unknown_actions", "reasons", "counterparts", "cut_off",
    ),
}  # fmt: skip
"""Keys that a header may have in addition to ``format``, by format. Earlier versions also wrote
``unknown_actions``, which are not read."""

EpisodeFields = dict[str, Any]
"""Fields of an ``Episode`` by name."""

Word = TypeVar("Word", bound=Hashable)

SCHEMAS: tuple[Schema, ...] = tuple(
    {name: (dtype, len(axes)) for name, (dtype, axes) in (columns | more).items()}
    for columns in (
        LONE_COLUMNS,
        LONE_COLUMNS | LINE_COLUMNS,
        FLEET_COLUMNS,
        REASONED_COLUMNS,
        HEADED_COLUMNS,
    )
    for more in ({}, READ_COLUMNS)
)


def schema_of(arrays: Arrays) -> Schema:
    """Return the schema that consists of these arrays."""
    return next(schema for schema in SCHEMAS if schema.keys() == arrays.keys())


def is_equal(one: object, other: object) -> bool:
    """Return whether two values of a field are equal; NaN in arrays and measures equals NaN."""
    if isinstance(one, FleetMeasures) and isinstance(other, FleetMeasures):
        one, other = np.array(astuple(one)), np.array(astuple(other))
    if isinstance(one, np.ndarray) and isinstance(other, np.ndarray):
        return one.dtype == other.dtype and np.array_equal(one, other, equal_nan=True)
    return one == other


def pack(fields: EpisodeFields) -> Arrays:
    """Return the arrays of an episode, with the types of their schema.

    Raises:
        RecordError: a value does not fit the type of its array.
        ValueError: the fields are not the fields of an episode. Depending on the field, this may
            also be a ``TypeError``, ``AttributeError`` or ``OverflowError``.
    """
    is_fleet = isinstance(fields["settings"], FleetSettings)
    motions = [*chain.from_iterable(fields["motions"])] if is_fleet else fields["motions"]
    arrays, counterparts = pack_motions(motions)
    header = {
        "format": FLEET_FORMAT if is_fleet else LONE_FORMAT,
        "settings": (FleetSettings if is_fleet else Settings).to_json(fields["settings"]),
    }
    (_pack_fleet if is_fleet else _pack_lone)(fields, arrays, header, counterparts)
    cut_off = [number for number, motion in enumerate(motions) if motion.cut_off]
    arrays["layout"] = pack_layout(fields["layout"])
    arrays["header"] = pack_header(header | ({"cut_off": cut_off} if cut_off else {}))
    for name in FLEET_COLUMNS if is_fleet else LONE_COLUMNS:
        if name not in arrays:
            arrays[name] = np.asarray(fields[FIELD_OF.get(name, name)])
    schema = schema_of(arrays)
    return {name: _typed(name, arrays[name], *schema[name]) for name in schema}


def unpack(arrays: Arrays) -> EpisodeFields:
    """Return the fields of an episode from its arrays, and check that they are consistent.

    Raises:
        ValueError: they are not consistent; it may be a ``RecordError`` or a ``LayoutError``.
    """
    is_fleet = "orders" in arrays
    form = FLEET_FORMAT if is_fleet else LONE_FORMAT
    header = unpack_header(arrays["header"], form, HEADER_KEYS[form])
    for name, types in SCALARS[form].items():
        if type(header.get(name, Any)) not in types:
            given = brief(header.get(name))
            raise RecordError(f"{name} is {given}; it must be {types[0].__name__}")
    fields = {name: header[name] for name in SCALARS[form]}
    fields["layout"] = unpack_layout(arrays["layout"])
    kind = FleetSettings if is_fleet else Settings
    fields["settings"] = kind.from_json(header.get("settings"))
    columns = (HEADED_COLUMNS if is_fleet else LONE_COLUMNS) | READ_COLUMNS | LINE_COLUMNS
    _check_arrays(arrays, columns, fields["settings"])
    fields["motions"] = unpack_motions(arrays, header)
    (_unpack_fleet if is_fleet else _unpack_lone)(arrays, header, fields)
    return fields


def _typed(name: str, array: NDArray[Any], dtype: str, dimensions: int) -> NDArray[Any]:
    """Return an array with the type of the schema, which must not change its values."""
    if array.dtype.kind in "biuf" and array.ndim == dimensions:
        with np.errstate(all="ignore"):
            typed = array.astype(dtype)
        if np.array_equal(typed, array, equal_nan=True):
            return typed
    raise RecordError(f"{name} cannot be stored as {np.dtype(dtype)} with {dimensions} dimensions")


def _pack_lone(
    fields: EpisodeFields, arrays: Arrays, header: EpisodeFields, counterparts: list[str]
) -> None:
    for name in ("actions", "reasons"):
        header[name], arrays[name] = encode_words(fields[name])
    header["counterparts"] = counterparts
    header |= {name: fields[name] for name in SCALARS[LONE_FORMAT]}


def _unpack_lone(arrays: Arrays, header: EpisodeFields, fields: EpisodeFields) -> None:
    layout, settings = fields["layout"], fields["settings"]
    cells = [(row, col) for row, col in arrays["cells"].tolist()]
    _check_open("start_pos", [settings.start_pos], layout)
    _check_open("cells", cells, layout)
    _check_open("slippery", settings.slippery, layout)
    _check_ends(arrays, arrays["cells"][1:])
    fields["cells"] = cells
    fields["actions"] = decode_words(header, "actions", arrays["actions"], {str, int})
    fields["reasons"] = decode_words(header, "reasons", arrays["reasons"])
    fields |= {name: arrays[name].tolist() for name in ("loaded", "battery", "rewards")}


def _pack_fleet(
    fields: EpisodeFields, arrays: Arrays, header: EpisodeFields, counterparts: list[str]
) -> None:
    measures = vars(fields["measures"])
    header["measures"] = {name: None if math.isnan(x) else x for name, x in measures.items()}
    header["counterparts"] = counterparts
    header |= {
        name: fields[name] for name in (*SCALARS[FLEET_FORMAT], "slippery", "motor_strength")
    }
    if fields["drive"]:
        header["drive"] = fields["drive"]
    settings, reasons = fields["settings"], fields["reasons"]
    if settings.has_headings:
        arrays["headings"] = np.asarray(fields["headings"])
        reasons = reasons or [("",) * settings.robots] * len(fields["actions"])
    if reasons or settings.has_headings:
        header["reasons"], codes = encode_words(chain.from_iterable(reasons))
        arrays["reasons"] = codes.reshape(-1, settings.robots)
    arrays["orders"] = np.array([*map(_numbers, fields["orders"])]).reshape(-1, LENGTHS["O"])
    arrays["assignments"] = np.array([*map(_without_none, fields["assignments"])]).reshape(-1, 3)


def _unpack_fleet(arrays: Arrays, header: EpisodeFields, fields: EpisodeFields) -> None:
    layout, settings = fields["layout"], fields["settings"]
    if fields["seed"] < 0 or not 0 < fields["cell_size"] < np.inf:
        raise RecordError(
            f"seed is {brief(fields['seed'])} and cell_size is {fields['cell_size']}; seed must be "
            "at least 0, and cell_size positive and finite"
        )
    fields |= conditions_in(header)
    _check_open("slippery", fields["slippery"], layout)
    for name in ("cells", "people"):
        _check_open(name, layout.cells(np.unique(arrays[name])), layout)
    bodies = np.hstack([arrays["cells"], arrays["people"]])[1:].ravel()
    _check_ends(arrays, layout.places(bodies[: len(arrays["motion_cells"])]))
    _check_numbers(arrays, settings)
    _check_headings(arrays, settings)
    _check_orders(arrays["orders"], layout, settings.robots, len(arrays["actions"]))
    for name in FLEET_COLUMNS.keys() - MOTION_COLUMNS.keys() - {"header", "layout"}:
        fields[FIELD_OF.get(name, name)] = arrays[name]
    fields["orders"] = [_order(numbers) for numbers in arrays["orders"].tolist()]
    fields["assignments"] = [tuple(_with_none(each)) for each in arrays["assignments"].tolist()]
    fields["motions"] = _rows(fields["motions"], settings.bodies)
    fields["measures"] = _read_measures(header.get("measures"))
    if "reasons" in arrays:
        words = decode_words(header, "reasons", arrays["reasons"].ravel())
        fields["reasons"] = _rows(words, settings.robots)
    if settings.has_headings:
        fields["headings"] = arrays["headings"]
        fields["reasons"] = fields["reasons"] if any(words) else []


def _check_arrays(arrays: Arrays, columns: ColumnSpecs, settings: Any) -> None:
    """Raise if the shape of an array does not fit the other arrays, or a number is impossible."""
    lists = ["motion_cells", "contacts"]
    lists += ["orders", "assignments"] if "orders" in arrays else ["cells"]
    objects = sum(len(arrays[name]) for name in lists)
    if objects > MAX_OBJECTS:
        raise RecordError(f"{listed(lists)} have {objects} rows; at most {MAX_OBJECTS} are allowed")
    lengths = _lengths(arrays, settings)
    for name, array in arrays.items():
        shape, (dtype, axes) = array.shape, columns[name]
        expected = tuple(map(lengths.get, axes, shape))
        if shape != expected:
            raise RecordError(f"{name} has the shape {shape}; it must be {expected}")
        if dtype == "<f8" and not (np.abs(array) <= MAX_NUMBER).all():  # NaN neither
            raise RecordError(f"{name} has a number outside {-MAX_NUMBER:g}..{MAX_NUMBER:g}")
    for name, least in {"path_lengths": 2, "contact_counts": 0, "line_counts": 0}.items():
        if name in arrays and arrays[name].min(initial=least) < least:
            raise RecordError(f"{name} has a number below {least}")
    seconds, joules = (
        [arrays[name].min(initial=1) for name in (unit, f"motion_{unit}") if name in arrays]
        for unit in ("seconds", "joules")
    )
    if min(seconds) <= 0 or min(joules) < 0:
        raise RecordError("a motion has seconds that are not positive, or negative joules")


def _lengths(arrays: Arrays, settings: Any) -> dict[str, int]:
    """Return the length of each axis whose length is fixed."""
    steps = len(arrays["actions"])
    lengths = {"T": steps, "F": steps + 1, "M": steps}
    if isinstance(settings, FleetSettings):
        lengths |= {"R": settings.robots, "P": settings.people.count}
        lengths["M"] = steps * settings.bodies if len(arrays["motion_cells"]) else 0
    sums = {"L": "path_lengths", "C": "contact_counts", "N": "line_counts"}
    totals = {
        axis: int(arrays[name].sum(dtype=np.int64)) for axis, name in sums.items() if name in arrays
    }
    return LENGTHS | lengths | totals


def _check_open(name: str, cells: Sequence[Cell], layout: Layout) -> None:
    for cell in cells:
        if not layout.is_open(cell):
            raise RecordError(f"{name}: {layout.describe(cell)}")


def _check_ends(arrays: Arrays, cells: NDArray[Any]) -> None:
    """Check that the motions, if there are any, end in these cells."""
    ends = arrays["motion_cells"]
    if not np.array_equal(ends, cells[: len(ends)]):
        raise RecordError("the motions do not end in the recorded cells of the robots and people")


def _check_numbers(arrays: Arrays, settings: FleetSettings) -> None:
    steps, robots, orders = arrays["assignments"].T
    for name, numbers, low, high in (
        ("actions", arrays["actions"], 0, INVALID),
        ("stopped_by", arrays["stopped_by"], WALL, settings.bodies - 1),
        ("steps of assignments", steps, 0, len(arrays["actions"])),
        ("robots of assignments", robots, 0, settings.robots - 1),
        ("orders of assignments", orders, NONE, len(arrays["orders"]) - 1),
    ):
        if not ((numbers >= low) & (numbers <= high)).all():
            raise RecordError(f"{name}: a number is outside {low}..{high}")


def _check_headings(arrays: Arrays, settings: FleetSettings) -> None:
    """Check that headings exist if and only if ``moves="turn"``, and that the actions fit."""
    if ("headings" in arrays) != settings.has_headings:
        state = "missing" if settings.has_headings else "not allowed"
        raise RecordError(f"headings are {state} for moves {settings.moves!r}")
    last, actions = len(settings.actions) - 1, arrays["actions"]
    if not ((actions <= last) | (actions == INVALID)).all():
        raise RecordError(f"actions: a number is outside 0..{last} and is not {INVALID}")
    if not np.isin(arrays.get("headings", 0), range(WAIT)).all():
        raise RecordError(f"headings: a number is outside 0..{WAIT - 1}")


def _check_orders(orders: NDArray[Any], layout: Layout, robots: int, steps: int) -> None:
    released, due, *cells, robot, taken_by, taken, delivered = orders.T
    for name, places in (("pickup", cells[:2]), ("dropoff", cells[2:])):
        pairs = set(zip(*(place.tolist() for place in places), strict=True))
        _check_open(f"the {name} of an order", [*pairs], layout)
    was_taken, was_delivered = taken != NONE, delivered != NONE
    rules = {
        "released before step 0 or after the last step, or due before its release": (
            (released >= 0) & (released <= steps) & (due >= released)
        ),
        "assigned to or taken by a robot that does not exist": (
            (np.minimum(robot, taken_by) >= NONE) & (np.maximum(robot, taken_by) < robots)
        ),
        "taken before its release, after the last step, or by no robot": (
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


def _read_measures(values: Any) -> FleetMeasures:
    kinds = FleetMeasures.__annotations__
    if isinstance(values, dict):  # older records do not count lost orders
        values = {"lost": 0} | values
    if not isinstance(values, dict) or values.keys() != kinds.keys():
        raise RecordError(f"measures must have the keys {', '.join(kinds)}")
    for name, value in values.items():
        is_whole = kinds[name] == "int"
        if not (type(value) is int if is_whole else type(value) is float or value is None):
            raise RecordError(f"{name} is {brief(value)}; it must be {kinds[name]}")
    numbers: dict[str, Any] = {name: math.nan if x is None else x for name, x in values.items()}
    return FleetMeasures(**numbers)


def pack_layout(layout: Layout) -> NDArray[np.uint8]:
    """Return the characters of a layout as bytes, ``[H, W]``."""
    tiles = np.frombuffer("".join(layout.rows).encode("ascii"), dtype=np.uint8)
    return tiles.reshape(layout.height, layout.width)


def unpack_layout(tiles: NDArray[np.uint8]) -> Layout:
    """Return the layout from the bytes of its characters, ``[H, W]``."""
    # The size is checked first: empty rows take no space in a file, but could be very many.
    if not 0 < tiles.size <= MAX_CELLS:
        raise RecordError(f"layout has the shape {tiles.shape}; it must have 1..{MAX_CELLS} tiles")
    check_size(*tiles.shape)
    return Layout([row.tobytes().decode("ascii") for row in tiles])


def encode_words(words: Iterable[Word]) -> tuple[list[Word], NDArray[np.int32]]:
    """Return the distinct words, and the index of each of ``words`` among them."""
    codes: dict[Word, int] = {}
    indices = [codes.setdefault(word, len(codes)) for word in words]
    return list(codes), np.array(indices, dtype=np.int32)


def decode_words(
    header: EpisodeFields, name: str, codes: NDArray[Any], kinds: Iterable[type] = (str,)
) -> list[Any]:
    """Return the words with these codes; the header has the distinct words."""
    words = header.get(name)
    if not isinstance(words, list) or not {type(word) for word in words} <= set(kinds):
        raise RecordError(f"{name} must be a list of words")
    if codes.size and not (codes.min() >= 0 and codes.max() < len(words)):
        raise RecordError(f"{name} has a code outside 0..{len(words) - 1}")
    return [words[code] for code in codes.tolist()]


def pack_motions(motions: Sequence[Outcome]) -> tuple[Arrays, list[str]]:
    """Return the arrays of ``MOTION_COLUMNS``, and the names of the counterparts in contacts.

    If all motions have readings, the arrays also include ``READ_COLUMNS``, and if all have lines,
    ``LINE_COLUMNS``.
    """
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
    readings = [motion.readings for motion in motions if motion.readings is not None]
    if readings and len(readings) == len(motions):
        arrays["readings"] = np.concatenate(readings)
    seen = [motion.lines for motion in motions if motion.lines is not None]
    if seen and len(seen) == len(motions):
        arrays["lines"] = np.concatenate(seen)
        arrays["line_counts"] = np.array([len(lines) for lines in seen])
    return arrays, counterparts


def unpack_motions(arrays: Arrays, header: EpisodeFields) -> list[Outcome]:
    """Return the motions from their arrays, which have been checked."""
    count, cut_off = len(arrays["motion_cells"]), header.get("cut_off", [])
    if not isinstance(cut_off, list) or not all(
        type(number) is int and 0 <= number < count for number in cut_off
    ):
        raise RecordError(f"cut_off must be a list of motions from 0 to {count - 1}")
    names = decode_words(header, "counterparts", arrays["contact_counterparts"])
    contacts = (
        Contact(seconds, impulse, (x, y), name)
        for (seconds, impulse, x, y), name in zip(arrays["contacts"].tolist(), names, strict=True)
    )
    columns = ("motion_cells", "motion_blocked", "motion_seconds", "motion_joules")
    ends = np.cumsum(arrays["path_lengths"])[:-1]
    seen = np.cumsum(arrays.get("line_counts", ()), dtype=np.intp)[:-1]
    rows = zip(
        *(arrays[name].tolist() for name in columns),
        np.split(arrays["path"], ends),
        arrays["contact_counts"].tolist(),
        np.split(arrays["readings"], ends) if "readings" in arrays else repeat(None),
        np.split(arrays["lines"], seen) if "lines" in arrays else repeat(None),
        strict=False,
    )
    motions = [
        Outcome(
            (row, col), blocked, seconds, joules, path, tuple(islice(contacts, count)),
            readings=readings, lines=lines,
        )
        for (row, col), blocked, seconds, joules, path, count, readings, lines in rows
    ]  # fmt: skip
    for number in cut_off:
        motions[number] = motions[number]._replace(cut_off=True)
    return motions


def _rows(values: list[Any], width: int) -> list[tuple[Any, ...]]:
    return [tuple(values[first : first + width]) for first in range(0, len(values), width)]


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
