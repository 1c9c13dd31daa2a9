import json
from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import Any

import numpy as np
import pytest

from warehouse_core import Episode, RecordError
from warehouse_core.files.npz import Arrays
from warehouse_core.records.arrays import LONE_SCHEMA, pack, unpack
from warehouse_core.world.layout import MAX_CELLS, MAX_ROWS

Load = Callable[..., Episode]


def as_text(header: object) -> np.ndarray:
    return np.frombuffer(json.dumps(header).encode(), dtype=np.uint8)


def header_of(arrays: Arrays) -> dict[str, Any]:
    return json.loads(arrays["header"].tobytes())


def refused(load: Load, **changed: np.ndarray) -> str:
    with pytest.raises(RecordError) as caught:
        load(**changed)
    return str(caught.value)


def changed_at(array: np.ndarray, place: Any, value: Any) -> np.ndarray:
    changed = array.copy()
    changed[place] = value
    return changed


def test_fields_load_as_they_were_packed(episode: Episode) -> None:
    fields = {name: getattr(episode, name) for name in episode.__slots__}
    arrays = pack(fields)
    assert arrays.keys() == LONE_SCHEMA.keys()
    assert Episode(**unpack(arrays)) == episode


def test_a_motion_that_was_cut_off_loads_as_such(episode: Episode) -> None:
    fields = {name: getattr(episode, name) for name in episode.__slots__}
    motions = [
        motion._replace(cut_off=step in (1, 4)) for step, motion in enumerate(episode.motions)
    ]
    assert unpack(pack(fields | {"motions": motions}))["motions"] == motions


def test_the_file_can_be_read_with_numpy_and_json_alone(arrays: Arrays, episode: Episode) -> None:
    header = header_of(arrays)
    assert header["format"] == "warehouse-lab episode 1"
    assert [header["actions"][code] for code in arrays["actions"]] == episode.actions
    assert arrays["layout"].tobytes().decode() == "".join(episode.layout.rows)
    assert arrays["rewards"].tolist() == episode.rewards


# The header.


@pytest.mark.parametrize("text", [b"{", b"\xff", b"[" * 50_000, b"9" * 5000])
def test_a_header_that_is_not_json_raises(load_changed: Load, text: bytes) -> None:
    message = refused(load_changed, header=np.frombuffer(text, dtype=np.uint8))
    assert "its header is no JSON text" in message


@pytest.mark.parametrize("header", [[], {}, {"format": "warehouse-lab episode 2"}])
def test_a_header_of_another_format_raises(load_changed: Load, header: object) -> None:
    message = refused(load_changed, header=as_text(header))
    assert "its format is not 'warehouse-lab episode 1'" in message


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *[("seed", bad) for bad in (1.0, True)],
        ("agent", None),
        ("terminated", 0),
        ("truncated", None),
        *[("actions", bad) for bad in (None, {"N": 0}, ["N", 1.0], [True], [["N"]])],
        *[("reasons", bad) for bad in ("greedy", [5])],
        ("counterparts", [5]),
        *[("settings", bad) for bad in (None, {})],
    ],
)
def test_a_header_with_an_invalid_value_raises(
    arrays: Arrays, load_changed: Load, name: str, value: object
) -> None:
    header = header_of(arrays)
    assert name in refused(load_changed, header=as_text(header | {name: value}))
    del header[name]
    assert name in refused(load_changed, header=as_text(header))


@pytest.mark.parametrize("value", [0, ["0"], [True], [-1], [10**6]])
def test_a_step_that_does_not_exist_cannot_be_cut_off(
    arrays: Arrays, load_changed: Load, value: object
) -> None:
    header = header_of(arrays) | {"cut_off": value}
    assert "cut_off must be a list of motions" in refused(load_changed, header=as_text(header))


@pytest.mark.parametrize("value", [float("nan"), 0.0])
def test_settings_are_checked(arrays: Arrays, load_changed: Load, value: float) -> None:
    header = header_of(arrays)
    header["settings"]["cell_size"] = value
    assert "cell_size is" in refused(load_changed, header=as_text(header))


@pytest.mark.parametrize("name", ["actions", "reasons", "counterparts"])
def test_a_vocabulary_that_is_too_short_raises(
    arrays: Arrays, load_changed: Load, name: str
) -> None:
    header = header_of(arrays)
    header[name] = header[name][:-1]
    assert "has a code outside" in refused(load_changed, header=as_text(header))


# The columns.


@pytest.mark.parametrize("value", [np.nan, -np.inf])
def test_a_reward_that_is_not_finite_raises(
    arrays: Arrays, load_changed: Load, value: float
) -> None:
    rewards = changed_at(arrays["rewards"], 7, value)
    assert "rewards has a number outside" in refused(load_changed, rewards=rewards)


@pytest.mark.parametrize("name", ["cells", "loaded", "battery", "rewards", "reasons", "actions"])
def test_columns_of_different_lengths_raise(arrays: Arrays, load_changed: Load, name: str) -> None:
    for array in (arrays[name][:-1], arrays[name][:0]):
        assert "has the shape" in refused(load_changed, **{name: array})


def test_cells_without_two_columns_raise(arrays: Arrays, load_changed: Load) -> None:
    for cells in (arrays["cells"][:, :1], np.repeat(arrays["cells"], 2, axis=1)):
        assert "cells has the shape" in refused(load_changed, cells=cells)


@pytest.mark.parametrize(
    ("cell", "message"),
    [
        ((0, 0), "row 0, column 0 is wall"),
        ((7, 1), "row 7, column 1 is off the grid"),
        ((2**31 - 1, 1), "row 2147483647, column 1 is off the grid"),
    ],
)
def test_a_robot_in_a_wall_raises(
    arrays: Arrays, load_changed: Load, cell: tuple[int, int], message: str
) -> None:
    cells = changed_at(arrays["cells"], 9, cell)
    assert f"no robot can be where {message}" in refused(load_changed, cells=cells)


def test_motions_that_end_in_another_cell_than_the_robot_raise(
    arrays: Arrays, load_changed: Load
) -> None:
    cells = changed_at(arrays["motion_cells"], 2, (0, 0))
    assert "other cells" in refused(load_changed, motion_cells=cells)


@pytest.mark.parametrize("start", [[0, 0], [-1, 1], [10**30, 1]])
def test_a_start_in_a_wall_raises(arrays: Arrays, load_changed: Load, start: list[int]) -> None:
    header = header_of(arrays)
    header["settings"]["start_pos"] = start
    assert "no robot can be where row" in refused(load_changed, header=as_text(header))


# The layout.


@pytest.mark.parametrize("tile", [ord("R"), 0xFF])
def test_an_unknown_tile_raises(arrays: Arrays, load_changed: Load, tile: int) -> None:
    refused(load_changed, layout=changed_at(arrays["layout"], (2, 3), tile))


def test_a_charger_is_a_tile_and_other_robots_and_people_are_none(
    arrays: Arrays, load_changed: Load
) -> None:
    load_changed(layout=changed_at(arrays["layout"], (2, 5), ord("C")))
    for character in "OoHc":
        message = refused(load_changed, layout=changed_at(arrays["layout"], (2, 5), ord(character)))
        assert f"row 2, column 5: {character!r} is not a tile" in message
        assert "C (charger)" in message


@pytest.mark.parametrize("shape", [(0, 12), (7, 0), (2**40, 0)])
def test_a_layout_without_tiles_raises_at_once(
    load_changed: Load,
    little_memory: Callable[[], AbstractContextManager[None]],
    shape: tuple[int, int],
) -> None:
    with little_memory():
        message = refused(load_changed, layout=np.zeros(shape, dtype=np.uint8))
    assert f"layout: {shape} tiles; there must be 1..{MAX_CELLS}" in message


def test_a_layout_above_the_limit_raises_before_its_rows_are_made(
    load_changed: Load, little_memory: Callable[[], AbstractContextManager[None]]
) -> None:
    layout = np.full((MAX_CELLS + 1, 1), ord("."), dtype=np.uint8)
    with little_memory():
        assert f"there must be 1..{MAX_CELLS}" in refused(load_changed, layout=layout)


def test_a_layout_of_very_many_rows_raises_before_they_are_made(
    load_changed: Load, little_memory: Callable[[], AbstractContextManager[None]]
) -> None:
    layout = np.full((MAX_ROWS + 1, 1), ord("?"), dtype=np.uint8)
    with little_memory():
        assert f"more than MAX_ROWS = {MAX_ROWS}" in refused(load_changed, layout=layout)


# The arrays of the file.


@pytest.mark.parametrize("name", ["header", "rewards", "loaded"])
def test_another_dtype_raises(arrays: Arrays, load_changed: Load, name: str) -> None:
    other = np.float32 if name != "rewards" else np.int64
    assert f"array {name} is" in refused(load_changed, **{name: arrays[name].astype(other)})


@pytest.mark.parametrize("name", ["header", "path"])
def test_another_number_of_dimensions_raises(arrays: Arrays, load_changed: Load, name: str) -> None:
    assert f"array {name} is" in refused(load_changed, **{name: arrays[name][..., np.newaxis]})


def test_an_array_of_objects_raises(arrays: Arrays, load_changed: Load) -> None:
    assert "array cells is object" in refused(load_changed, cells=arrays["cells"].astype(object))


def test_an_additional_array_raises(load_changed: Load) -> None:
    message = refused(load_changed, more=np.zeros(1))
    assert "18 arrays; there must be 17, 24 or 25" in message


def test_a_slippery_wall_raises(arrays: Arrays, load_changed: Load) -> None:
    header = header_of(arrays)
    header["settings"]["slippery"] = [[1, 1], [0, 0]]
    message = refused(load_changed, header=as_text(header))
    assert "no floor is slippery where row 0, column 0 is wall" in message
