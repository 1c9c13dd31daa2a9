import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.fleets import fleet_episode

from warehouse_core import FleetEpisode, RecordError
from warehouse_core.files.npz import Arrays, read_arrays
from warehouse_core.records.arrays import (
    END_COLUMNS,
    FLEET_SCHEMA,
    FRAME_COLUMNS,
    STEP_COLUMNS,
)

Refused = Callable[..., str]


@pytest.fixture(scope="module")
def arrays(tmp_path_factory: pytest.TempPathFactory) -> Arrays:
    path = tmp_path_factory.mktemp("fleet") / "fleet.npz"
    fleet_episode(backend="physics", max_steps=30).save(path)
    return read_arrays(path, FLEET_SCHEMA)


@pytest.fixture
def refused(arrays: Arrays, tmp_path: Path) -> Refused:
    """Return a function that changes arrays or the header, and returns why that does not load."""

    def refuse(**changed: Any) -> str:
        header = json.loads(arrays["header"].tobytes()) | changed.pop("header", {})
        text = np.frombuffer(json.dumps(header).encode(), np.uint8)
        np.savez_compressed(tmp_path / "changed.npz", **(arrays | {"header": text} | changed))
        with pytest.raises(RecordError) as caught:
            FleetEpisode.load(tmp_path / "changed.npz")
        return str(caught.value)

    return refuse


def changed_at(array: np.ndarray, place: Any, value: Any) -> np.ndarray:
    changed = array.copy()
    changed[place] = value
    return changed


def test_unchanged_arrays_load(arrays: Arrays, tmp_path: Path) -> None:
    np.savez_compressed(tmp_path / "same.npz", **arrays)
    assert FleetEpisode.load(tmp_path / "same.npz").steps == 30


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("format", "warehouse-lab episode 1"),
        *[("seed", bad) for bad in (None, -1, 1.0)],
        *[("cell_size", bad) for bad in (1, 0.0, float("nan"))],
        *[("backend", bad) for bad in (None, ["grid"])],
        ("agent", 3),
        *[("counterparts", bad) for bad in (None, [1])],
        *[("measures", bad) for bad in (None, {}, {"steps": 1})],
        *[("settings", bad) for bad in (None, {}, [])],
        ("motor_strength", 2.0),
        *[("slippery", bad) for bad in (5, [[1]], [[0, 0]])],
    ],
)
def test_a_header_with_an_invalid_value_is_refused(
    refused: Refused, name: str, value: object
) -> None:
    assert name in refused(header={name: value})


@pytest.mark.parametrize(
    ("name", "value"), [("steps", 1.5), ("steps", None), ("joules", "1"), ("per_hour", True)]
)
def test_measures_have_their_types(
    arrays: Arrays, refused: Refused, name: str, value: object
) -> None:
    measures = json.loads(arrays["header"].tobytes())["measures"]
    assert f"{name} is {value!r}" in refused(header={"measures": measures | {name: value}})


@pytest.mark.parametrize("name", [*FRAME_COLUMNS, *STEP_COLUMNS])
def test_arrays_of_other_shapes_are_refused(arrays: Arrays, refused: Refused, name: str) -> None:
    for array in (arrays[name][:-1], arrays[name][:, :-1], np.repeat(arrays[name], 2, axis=1)):
        if name != "actions" or array.shape[1] != arrays[name].shape[1]:
            assert f"{name} has the shape {array.shape}" in refused(**{name: array})
    assert "it must be" in refused(actions=arrays["actions"][:-1])


@pytest.mark.parametrize("name", [*END_COLUMNS, "orders", "assignments"])
def test_other_numbers_of_robots_or_columns_are_refused(
    arrays: Arrays, refused: Refused, name: str
) -> None:
    array = arrays[name][..., :-1]
    assert f"{name} has the shape {array.shape}" in refused(**{name: array})


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("cells", -1, "cells: a number is outside 0.."),
        ("cells", 0, "cells: row 0, column 0 is wall"),
        ("people", 10**6, "people: a number is outside 0.."),
        ("people", 0, "people: row 0, column 0 is wall"),
        ("actions", 8, "actions: a number is outside 0..7"),
        ("actions", -1, "actions: a number is outside 0..7"),
        ("stopped_by", -3, "stopped_by: a number is outside -2..5"),
        ("stopped_by", 6, "stopped_by: a number is outside -2..5"),
        ("rewards", np.nan, "rewards has a number outside"),
        ("battery", np.inf, "battery has a number outside"),
        ("joules", -1.0, "took no time, or less than no energy"),
        ("seconds", 0.0, "took no time, or less than no energy"),
    ],
)
def test_impossible_values_are_refused(
    arrays: Arrays, refused: Refused, name: str, value: float, message: str
) -> None:
    assert message in refused(**{name: changed_at(arrays[name], (-1, 1), value)})


RELEASED, DUE, PICKUP, DROPOFF, ROBOT, TAKEN_BY, TAKEN, DELIVERED = 0, 1, 2, 4, 6, 7, 8, 9


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({RELEASED: -1}, "order 0 is released before step 0"),
        ({RELEASED: 31, DUE: 40}, "order 0 is released before step 0 or after the last"),
        ({DUE: 0}, "or due before"),
        ({PICKUP: -1}, "an order has a pickup off the grid"),
        ({DROPOFF + 1: 99}, "an order has a dropoff off the grid"),
        ({PICKUP: 0}, "an order's pickup: row 0"),
        ({ROBOT: 4}, "for or taken by a robot that does not exist"),
        ({TAKEN_BY: -2}, "for or taken by a robot that does not exist"),
        ({TAKEN_BY: -1}, "or by nobody"),
        ({TAKEN: -1, DELIVERED: -1}, "or by nobody"),
        ({TAKEN: 31}, "after the last step"),
        ({RELEASED: 5}, "taken before it was released"),
        ({DELIVERED: 3}, "delivered before it was taken"),
        ({DELIVERED: 31}, "or after the last step"),
    ],
)
def test_impossible_orders_are_refused(
    arrays: Arrays, refused: Refused, changes: dict[int, int], message: str
) -> None:
    orders = np.array(arrays["orders"])
    orders[0, [RELEASED, DUE]], orders[0, ROBOT:] = (2, 9), (-1, 1, 4, 7)
    orders[0, RELEASED] = 1
    for column, value in changes.items():
        orders[0, column] = value
    assert message in refused(orders=orders)


@pytest.mark.parametrize(
    ("assignment", "message"),
    [
        ([31, 0, 0], "steps of assignments: a number is outside 0..30"),
        ([0, 4, 0], "robots of assignments: a number is outside 0..3"),
        ([0, 0, 10**6], "orders of assignments: a number is outside -1.."),
    ],
)
def test_impossible_assignments_are_refused(
    refused: Refused, assignment: list[int], message: str
) -> None:
    assert message in refused(assignments=np.array([assignment], np.int32))


def test_motions_end_where_robots_and_people_are(arrays: Arrays, refused: Refused) -> None:
    for place in ((0, 0), (-1, 1)):
        other = changed_at(arrays["motion_cells"], place, 1 + arrays["motion_cells"][place])
        assert "the motions end in other cells" in refused(motion_cells=other)
    assert "motion_cells: 1; there must be 180" in refused(motion_cells=np.ones((1, 2), "<i4"))


@pytest.mark.parametrize(
    "changes",
    [
        {"dispatch": 1},
        {"robots": "4"},
        {"robots": 10**9},
        {"battery": {"capacity": 0}},
        {"battery": {"volts": 1}},
        {"people": 3},
        {"orders": [1]},
        {"orders": [{"rate": float("nan")}]},
        {"orders": [[0, 1, [1, 1], [1, 2], None, None, None, "late"]]},
        {"orders": [[0, 1, [1, 1]]]},
        {"orders": []},
        {"starts": [[1, 1, 1]] * 4},
        {"wheels": 4},
    ],
)
def test_settings_are_checked(arrays: Arrays, refused: Refused, changes: dict[str, Any]) -> None:
    settings = json.loads(arrays["header"].tobytes())["settings"]
    assert "changed.npz: " in refused(header={"settings": settings | changes})
