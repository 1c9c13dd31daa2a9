"""The fields of an episode as arrays, and back: the content of a ``.npz`` file.

``T`` is the number of steps and ``F = T + 1`` of frames. Words are stored as codes; the words
themselves and all other values are in ``header``, which is JSON text.
"""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warehouse_core.errors import RecordError
from warehouse_core.files.npz import Arrays, Schema
from warehouse_core.records.motion_arrays import (
    MOTION_SCHEMA,
    decode_words,
    encode_words,
    pack_motions,
    unpack_motions,
)
from warehouse_core.task.settings import Settings
from warehouse_core.world.layout import MAX_CELLS, Layout
from warehouse_core.world.tiles import Cell

FORMAT = "warehouse-lab episode 1"

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


def pack_fields(fields: Fields) -> Arrays:
    """Return the arrays of ``EPISODE_SCHEMA`` for the fields of an episode."""
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
    layout: Layout = fields["layout"]
    tiles = np.frombuffer("".join(layout.rows).encode("ascii"), dtype=np.uint8)
    return {
        "header": np.frombuffer(json.dumps(header).encode("utf-8"), dtype=np.uint8),
        "layout": tiles.reshape(layout.height, layout.width),
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
    header = _read_header(arrays)
    steps = len(arrays["actions"])
    _check_columns(arrays, steps)
    fields: Fields = {
        "layout": _read_layout(arrays["layout"]),
        "settings": Settings.from_json(header["settings"]),
        "cells": [(row, col) for row, col in arrays["cells"].tolist()],
        "actions": decode_words(header["actions"], arrays["actions"], "actions"),
        "reasons": decode_words(header["reasons"], arrays["reasons"], "reasons"),
        "motions": unpack_motions(arrays, header["counterparts"], steps),
    }
    fields |= {name: header[name] for name in ("seed", "agent", "terminated", "truncated")}
    fields |= {name: arrays[name].tolist() for name in ("loaded", "battery", "rewards")}
    _check_cells(fields["layout"], [fields["settings"].start_pos, *fields["cells"]])
    if [motion.cell for motion in fields["motions"]] != fields["cells"][1:]:
        raise RecordError("the motions end in other cells than the robot was in")
    return fields


def _read_layout(tiles: NDArray[np.uint8]) -> Layout:
    # Checked first: rows without columns take no room in a file, but could be very many.
    if not 0 < tiles.size <= MAX_CELLS:
        raise RecordError(f"layout: {tiles.shape} tiles; there must be 1..{MAX_CELLS}")
    return Layout([row.tobytes().decode("ascii") for row in tiles])


def _read_header(arrays: Arrays) -> dict[str, Any]:
    try:
        header = json.loads(arrays["header"].tobytes().decode("utf-8"))
    except (ValueError, RecursionError) as error:
        raise RecordError(f"its header is no JSON text: {error}") from error
    if not isinstance(header, dict) or header.get("format") != FORMAT:
        raise RecordError(f"its format is not {FORMAT!r}")
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
    return header | {"settings": header.get("settings")}


def _check_columns(arrays: Arrays, steps: int) -> None:
    for name in ("cells", "loaded", "battery", "rewards"):
        if len(arrays[name]) != steps + 1:
            raise RecordError(f"{name}: {len(arrays[name])} entries for {steps} steps")
    if len(arrays["reasons"]) != steps:
        raise RecordError(f"reasons: {len(arrays['reasons'])} entries for {steps} steps")
    if arrays["cells"].shape[1] != 2 or not np.isfinite(arrays["rewards"]).all():
        raise RecordError("cells are no (row, column) pairs, or a reward is not finite")


def _check_cells(layout: Layout, cells: list[Cell]) -> None:
    for cell in cells:
        if not layout.is_open(cell):
            raise RecordError(f"no robot can be where {layout.describe(cell)}")
