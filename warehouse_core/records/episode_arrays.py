"""The fields of an episode as arrays, and back: the content of a ``.npz`` file.

``T`` is the number of steps and ``F = T + 1`` of frames. Words are stored as codes; the words
themselves and all other values are in ``header``, which is JSON text. Paths and contacts of all
motions are concatenated.
"""

from __future__ import annotations

import json
import operator
from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import asdict
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from warehouse_core.errors import RecordError
from warehouse_core.files.npz import Arrays, Schema
from warehouse_core.motion.base import Contact, Outcome
from warehouse_core.task.settings import Settings
from warehouse_core.world.layout import MAX_CELLS, Layout, check_size
from warehouse_core.world.tiles import Cell

FORMAT = "warehouse-lab episode 1"

MAX_NUMBER = 1e12
"""Limit on the size of a reward, time, energy, impulse or coordinate, so that sums are finite."""

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

EPISODE_SCHEMA: Schema = {
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

Fields = dict[str, Any]
"""The fields of an ``Episode`` by name."""

Word = TypeVar("Word", bound=Hashable)


def pack_fields(fields: Fields) -> Arrays:
    """Return the arrays of ``EPISODE_SCHEMA`` for the fields of an episode.

    Raises:
        RecordError: ``unpack_fields`` would not return these fields.
    """
    return pack_checked(fields, EPISODE_SCHEMA, _packed, unpack_fields)


def pack_checked(
    fields: Fields,
    schema: Schema,
    pack: Callable[[Fields], Arrays],
    unpack: Callable[[Arrays], Fields],
    is_equal: Callable[[Any, Any], bool] = operator.eq,
) -> Arrays:
    """Return the arrays of a schema for some fields.

    Args:
        fields: by name.
        schema: of the arrays.
        pack: makes arrays of fields.
        unpack: undoes it.
        is_equal: whether two values of a field are equal.

    Raises:
        RecordError: ``unpack`` would not return these fields.
    """
    try:
        packed = pack(fields)
        arrays = {
            name: _typed(name, packed[name], dtype, dimensions)
            for name, (dtype, dimensions) in schema.items()
        }
        loaded = unpack(arrays)
        changed = [name for name, value in fields.items() if not is_equal(loaded[name], value)]
    except RecordError:
        raise
    except (TypeError, ValueError, AttributeError, OverflowError) as error:
        raise RecordError(f"the fields cannot be stored: {error}") from error
    if changed:
        raise RecordError(f"{changed[0]} would be loaded with other values or types")
    return arrays


def _typed(name: str, array: NDArray[Any], dtype: str, dimensions: int) -> NDArray[Any]:
    """Return an array in the type of the schema, which must not change its values."""
    if array.dtype.kind in "biuf" and array.ndim == dimensions:
        with np.errstate(all="ignore"):
            typed = array.astype(dtype)
        if np.array_equal(typed, array, equal_nan=True):
            return typed
    raise RecordError(f"{name} cannot be stored as {np.dtype(dtype)} with {dimensions} dimensions")


def _packed(fields: Fields) -> Arrays:
    action_words, actions = encode_words(fields["actions"])
    reason_words, reasons = encode_words(fields["reasons"])
    motion_arrays, counterparts = pack_motions(fields["motions"])
    header = {
        "format": FORMAT,
        "settings": asdict(fields["settings"]),
        "actions": action_words,
        "reasons": reason_words,
        "counterparts": counterparts,
    } | {name: fields[name] for name in ("seed", "agent", "terminated", "truncated")}
    cut_off = [step for step, motion in enumerate(fields["motions"]) if motion.cut_off]
    header |= {"cut_off": cut_off} if cut_off else {}
    return {
        "header": pack_header(header),
        "layout": pack_layout(fields["layout"]),
        "actions": actions,
        "reasons": reasons,
        **{name: np.array(fields[name]) for name in ("cells", "loaded", "battery", "rewards")},
        **motion_arrays,
    }


def unpack_fields(arrays: Arrays) -> Fields:
    """Undo ``pack_fields``, checking that the fields fit together.

    Raises:
        ValueError: they do not; it may be a ``RecordError`` or a ``LayoutError``.
    """
    steps = len(arrays["actions"])
    header = _read_header(arrays, steps)
    _check_columns(arrays, steps)
    fields: Fields = {
        "layout": unpack_layout(arrays["layout"]),
        "settings": Settings.from_json(header["settings"]),
        "cells": [(row, col) for row, col in arrays["cells"].tolist()],
        "actions": decode_words(header["actions"], arrays["actions"], "actions"),
        "reasons": decode_words(header["reasons"], arrays["reasons"], "reasons"),
        "motions": unpack_motions(arrays, header["counterparts"], steps),
    }
    fields |= {name: header[name] for name in ("seed", "agent", "terminated", "truncated")}
    fields |= {name: arrays[name].tolist() for name in ("loaded", "battery", "rewards")}
    for step in header["cut_off"]:
        fields["motions"][step] = fields["motions"][step]._replace(cut_off=True)
    for cell in (fields["settings"].start_pos, *fields["cells"]):
        if not fields["layout"].is_open(cell):
            raise RecordError(f"no robot can be where {fields['layout'].describe(cell)}")
    check_slippery(fields["layout"], fields["settings"].slippery)
    if [motion.cell for motion in fields["motions"]] != fields["cells"][1:]:
        raise RecordError("the motions end in other cells than the robot was in")
    return fields


def check_slippery(layout: Layout, cells: Iterable[Cell]) -> None:
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


def _read_header(arrays: Arrays, steps: int) -> dict[str, Any]:
    header = unpack_header(arrays["header"], FORMAT)
    allowed: dict[str, tuple[type, ...]] = {
        "seed": (int, type(None)),
        "agent": (str,),
        "terminated": (bool,),
        "truncated": (bool,),
    }
    for name, types in allowed.items():
        if type(header.get(name, Any)) not in types:
            raise RecordError(f"{name} is {header.get(name)!r}; it must be {types[0].__name__}")
    words: dict[str, set[type]] = {"actions": {str, int}, "reasons": {str}, "counterparts": {str}}
    for name, kinds in words.items():
        entries = header.get(name)
        if not isinstance(entries, list) or not {type(entry) for entry in entries} <= kinds:
            raise RecordError(f"{name} must be a list of words")
    cut_off = header.get("cut_off", [])
    if not isinstance(cut_off, list) or not all(
        type(step) is int and 0 <= step < steps for step in cut_off
    ):
        raise RecordError(f"cut_off must be a list of steps from 0 to {steps - 1}")
    return header | {"settings": header.get("settings"), "cut_off": cut_off}


def _check_columns(arrays: Arrays, steps: int) -> None:
    for name in ("cells", "loaded", "battery", "rewards"):
        if len(arrays[name]) != steps + 1:
            raise RecordError(f"{name}: {len(arrays[name])} entries for {steps} steps")
    if len(arrays["reasons"]) != steps:
        raise RecordError(f"reasons: {len(arrays['reasons'])} entries for {steps} steps")
    if arrays["cells"].shape[1] != 2:
        raise RecordError("cells are no (row, column) pairs")
    check_numbers(arrays, "rewards")


def check_numbers(arrays: Arrays, *names: str) -> None:
    """Raise if one of these arrays has a number beyond ``MAX_NUMBER``, or NaN."""
    for name in names:
        if not (np.abs(arrays[name]) <= MAX_NUMBER).all():  # NaN neither
            raise RecordError(f"{name} has a number outside {-MAX_NUMBER:g}..{MAX_NUMBER:g}")


def encode_words(words: Sequence[Word]) -> tuple[list[Word], NDArray[np.int32]]:
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


def pack_motions(motions: Sequence[Outcome]) -> tuple[Arrays, list[str]]:
    """Return the arrays of ``MOTION_SCHEMA`` and the vocabulary of counterparts."""
    contacts = [contact for motion in motions for contact in motion.contacts]
    counterparts, codes = encode_words([contact.counterpart for contact in contacts])
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
    return arrays, counterparts


def unpack_motions(arrays: Arrays, counterparts: list[str], steps: int) -> list[Outcome]:
    """Undo ``pack_motions``, checking that the arrays fit together.

    Raises:
        RecordError: they do not, or a value is impossible.
    """
    _check_motions(arrays, steps)
    names = decode_words(counterparts, arrays["contact_counterparts"], "contact_counterparts")
    contacts = [
        Contact(seconds, impulse, (x, y), name)
        for (seconds, impulse, x, y), name in zip(arrays["contacts"].tolist(), names, strict=True)
    ]
    paths = np.split(arrays["path"], np.cumsum(arrays["path_lengths"])[:-1]) if steps else []
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
    return [
        Outcome((row, col), blocked, seconds, joules, path, tuple(contacts[start:end]))
        for (row, col), blocked, seconds, joules, path, start, end in rows
    ]


def _check_motions(arrays: Arrays, steps: int) -> None:
    contacts = int(arrays["contact_counts"].sum(dtype=np.int64))
    each_step = (
        "motion_cells", "motion_blocked", "motion_seconds", "motion_joules",
        "path_lengths", "contact_counts",
    )  # fmt: skip
    columns = {"path": 4, "contacts": 4, "motion_cells": 2}
    sizes = {
        **{name: (len(arrays[name]), steps) for name in each_step},
        **{f"{name} columns": (arrays[name].shape[1], count) for name, count in columns.items()},
        "path": (len(arrays["path"]), int(arrays["path_lengths"].sum(dtype=np.int64))),
        "contacts": (len(arrays["contacts"]), contacts),
        "contact_counterparts": (len(arrays["contact_counterparts"]), contacts),
    }
    for name, (found, expected) in sizes.items():
        if found != expected:
            raise RecordError(f"{name}: {found}; there must be {expected}")
    if steps and (arrays["path_lengths"].min() < 2 or arrays["contact_counts"].min() < 0):
        raise RecordError("a path has fewer than two rows, or a count is negative")
    check_numbers(arrays, "motion_seconds", "motion_joules", "path", "contacts")
    if arrays["motion_seconds"].min(initial=1) <= 0 or arrays["motion_joules"].min(initial=0) < 0:
        raise RecordError("a motion took no time, or less than no energy")


def pack_header(header: dict[str, Any]) -> NDArray[np.uint8]:
    """Return a header as the bytes of JSON text.

    Raises:
        RecordError: a value cannot be written as JSON.
    """
    texts = []
    for name, value in header.items():
        try:
            texts.append(f"{json.dumps(name)}: {json.dumps(value, default=operator.index)}")
        except (TypeError, ValueError, RecursionError) as error:
            raise RecordError(f"{name} cannot be written as JSON: {error}") from error
    return np.frombuffer(f"{{{', '.join(texts)}}}".encode(), dtype=np.uint8)


def unpack_header(data: NDArray[np.uint8], name: str) -> dict[str, Any]:
    """Undo ``pack_header``.

    Raises:
        RecordError: the data are no JSON text, or its ``format`` is not ``name``.
    """
    try:
        header = json.loads(data.tobytes().decode("utf-8"))
    except (ValueError, RecursionError) as error:
        raise RecordError(f"its header is no JSON text: {error}") from error
    if not isinstance(header, dict) or header.get("format") != name:
        raise RecordError(f"its format is not {name!r}")
    return header
