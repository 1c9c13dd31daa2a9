"""Records as arrays: what is stored is loaded, and what does not fit together is refused."""

import dataclasses
import json
from collections.abc import Callable
from contextlib import AbstractContextManager
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.fleets import fleet_episode

from agents.warehouse_agent_greedy import GreedyAgent
from warehouse_core import (
    DEFAULT_LAYOUT,
    Episode,
    Outcome,
    RecordError,
    WarehouseEnv,
    record_episode,
)
from warehouse_core.files.npz import Arrays
from warehouse_core.records import arrays as arrays_module
from warehouse_core.records.arrays import FLEET_COLUMNS, LONE_COLUMNS, pack, unpack
from warehouse_core.world.layout import MAX_CELLS, MAX_ROWS
from warehouse_physics import Disturbances, RigidBodyMotion

Refused = Callable[..., str]
LONE, FLEET = "lone", "fleet"


class Explorer:
    """Bumps into things, and says so."""

    def reset(self) -> None:
        self.actions = list("NNEESSWWEN") * 3

    def act(self, observation: object) -> str | int:
        self.reason = "müde" if len(self.actions) % 2 else ""
        return 99 if len(self.actions) == 7 else self.actions.pop()


@cache
def episode_of(kind: str) -> Episode:
    if kind == FLEET:
        return fleet_episode(backend="physics", max_steps=30)
    return record_episode(WarehouseEnv(max_steps=20, backend="physics"), Explorer(), seed=3)


def arrays_of(kind: str) -> Arrays:
    episode = episode_of(kind)
    return pack({name: getattr(episode, name) for name in Episode.__slots__})


def as_text(header: object) -> np.ndarray:
    return np.frombuffer(json.dumps(header).encode(), dtype=np.uint8)


def header_of(arrays: Arrays) -> dict[str, Any]:
    return json.loads(arrays["header"].tobytes())


def changed_at(array: np.ndarray, place: Any, value: Any) -> np.ndarray:
    changed = array.copy()
    changed[place] = value
    return changed


@pytest.fixture
def refused(tmp_path: Path) -> Refused:
    """Return a function that changes arrays or the header, and returns why that does not load."""

    def refuse(kind: str, header: Any = None, **changed: np.ndarray) -> str:
        arrays = arrays_of(kind)
        if header is not None:
            is_part = isinstance(header, dict)
            changed["header"] = as_text(header_of(arrays) | header) if is_part else header
        np.savez(tmp_path / "changed.npz", **(arrays | changed))
        with pytest.raises(RecordError, match=r"changed\.npz: ") as caught:
            Episode.load(tmp_path / "changed.npz")
        return str(caught.value)

    return refuse


@pytest.mark.parametrize("kind", [LONE, FLEET])
def test_fields_load_as_they_were_packed(kind: str) -> None:
    episode = episode_of(kind)
    assert Episode(**unpack(arrays_of(kind))) == episode
    motions = episode.motions if kind == LONE else sum(episode.motions, ())
    assert any(motion.contacts for motion in motions)


def test_a_knee_is_in_the_header_only_if_there_is_one() -> None:
    battery = header_of(arrays_of(FLEET))["settings"]["battery"]
    assert battery.keys() == {"capacity", "unit", "charge"}


@pytest.mark.parametrize("kind", [LONE, FLEET])
def test_motions_that_were_cut_off_load_as_such(kind: str) -> None:
    fields = {name: getattr(episode_of(kind), name) for name in Episode.__slots__}

    def cut(motion: Outcome, step: int) -> Outcome:
        return motion._replace(cut_off=step in (1, 4))

    motions = [
        cut(each, step) if kind == LONE else (*each[:2], cut(each[2], step), *each[3:])
        for step, each in enumerate(fields["motions"])
    ]
    assert unpack(pack(fields | {"motions": motions}))["motions"] == motions


# The header.


@pytest.mark.parametrize("text", [b"{", b"\xff", b"[]", b"[" * 50_000, b"9" * 5000])
def test_a_header_that_is_no_json_object_is_refused(refused: Refused, text: bytes) -> None:
    message = refused(LONE, header=np.frombuffer(text, dtype=np.uint8))
    assert "its header: " in message


@pytest.mark.parametrize("kind", [LONE, FLEET])
def test_an_unknown_key_of_a_header_is_refused(refused: Refused, kind: str) -> None:
    header = header_of(arrays_of(kind)) | {"x" * 5000: []}
    message = refused(kind, header=as_text(header))
    assert "unknown key 'xxxxxxxxxxxx...xxxxxxxxxxxxx'; allowed: settings, " in message


@pytest.mark.parametrize("header", [{}, {"format": "warehouse-lab fleet episode 1"}])
def test_a_header_of_another_format_is_refused(refused: Refused, header: object) -> None:
    message = refused(LONE, header=as_text(header))
    assert "its format is not 'warehouse-lab episode 1'" in message


LONE_HEADER: dict[str, tuple[Any, ...]] = {
    "seed": (1.0, True),
    "agent": (None,),
    "terminated": (0,),
    "truncated": (None,),
    "actions": (None, {"N": 0}, ["N", 1.0], [True], [["N"]]),
    "reasons": ("greedy", [5]),
    "counterparts": ([5],),
    "settings": (None, {}),
}
FLEET_HEADER: dict[str, tuple[Any, ...]] = {
    "format": ("warehouse-lab episode 1",),
    "seed": (None, -1, 1.0),
    "cell_size": (1, 0.0, float("nan")),
    "backend": (None, ["grid"]),
    "agent": (3,),
    "counterparts": (None, [1]),
    "measures": (None, {}, {"steps": 1}),
    "settings": (None, {}, []),
}
OPTIONAL: dict[str, tuple[Any, ...]] = {
    "motor_strength": (2.0,),
    "drive": (5,),
    "slippery": (5, [[1]], [[1, 1], [0, 0]]),
    "cut_off": (0, ["0"], [True], [-1], [180]),
}  # fmt: skip


@pytest.mark.parametrize(
    ("kind", "name", "value"),
    [
        (kind, name, value)
        for kind, values in ((LONE, LONE_HEADER), (FLEET, FLEET_HEADER | OPTIONAL))
        for name, bad in values.items()
        for value in bad
    ],
)
def test_a_header_with_an_invalid_value_is_refused(refused, kind, name, value) -> None:
    assert name in refused(kind, header={name: value})
    if name not in OPTIONAL:
        header = header_of(arrays_of(kind))
        del header[name]
        assert name in refused(kind, header=as_text(header))


@pytest.mark.parametrize(
    ("name", "value"), [("steps", 1.5), ("steps", None), ("joules", "1"), ("per_hour", True)]
)
def test_measures_have_their_types(refused: Refused, name: str, value: object) -> None:
    measures = header_of(arrays_of(FLEET))["measures"] | {name: value}
    assert f"{name} is {value!r}" in refused(FLEET, header={"measures": measures})


@pytest.mark.parametrize(
    ("kind", "changes"),
    [
        *[(LONE, {"cell_size": size}) for size in (float("nan"), 0.0)],
        *[(LONE, {"start_pos": cell}) for cell in ([0, 0], [-1, 1], [10**30, 1])],
        (LONE, {"slippery": [[1, 1], [0, 0]]}),
        (FLEET, {"dispatch": 1}),
        (FLEET, {"robots": "4"}),
        (FLEET, {"robots": 10**9}),
        (FLEET, {"battery": {"capacity": 0}}),
        (FLEET, {"battery": {"volts": 1}}),
        (FLEET, {"people": 3}),
        (FLEET, {"orders": [1]}),
        (FLEET, {"orders": [{"rate": float("nan")}]}),
        (FLEET, {"orders": [[0, 1, [1, 1], [1, 2], None, None, None, "late"]]}),
        (FLEET, {"orders": [[0, 1, [1, 1]]]}),
        (FLEET, {"orders": []}),
        (FLEET, {"starts": [[1, 1, 1]] * 4}),
        (FLEET, {"wheels": 4}),
    ],
)
def test_settings_are_checked(refused: Refused, kind: str, changes: dict[str, Any]) -> None:
    given = header_of(arrays_of(kind))["settings"]
    name = next(iter(changes))
    message = refused(kind, header={"settings": given | changes})
    assert name in message or kind == FLEET


@pytest.mark.parametrize("name", ["actions", "reasons", "counterparts"])
def test_a_vocabulary_that_is_too_short_is_refused(refused: Refused, name: str) -> None:
    words = header_of(arrays_of(LONE))[name][:-1]
    assert f"{name} has a code outside 0..{len(words) - 1}" in refused(LONE, header={name: words})


# The arrays.


@pytest.mark.parametrize(
    ("kind", "name", "axis"),
    [
        (kind, name, axis)
        for kind, columns in ((LONE, LONE_COLUMNS), (FLEET, FLEET_COLUMNS))
        for name, (_, axes) in columns.items()
        for axis, letter in enumerate(axes)
        if letter != "*"
    ],
)
def test_arrays_of_other_shapes_are_refused(refused, kind, name, axis) -> None:
    array = arrays_of(kind)[name]
    for other in (array.take(range(array.shape[axis] - 1), axis), np.repeat(array, 2, axis)):
        message = refused(kind, **{name: other})
        assert " has the shape " in message
        if name not in ("actions", "contact_counts", "path_lengths"):  # others are measured by it
            assert f"{name} has the shape {other.shape}; it must be {array.shape}" in message


def test_additional_arrays_are_refused(refused: Refused) -> None:
    more = {f"more {number}": np.zeros(1) for number in range(3)}
    assert "21 arrays; there must be 17, 18, 19, 20, 24, 25, 26 or 27" in refused(LONE, **more)


AMOUNTS = "a motion has seconds that are not positive, or negative joules"


@pytest.mark.parametrize(
    ("kind", "name", "place", "value", "message"),
    [
        *[(kind, name, -1, value, f"{name} has a number outside -1e+12..1e+12")
          for kind, names in ((LONE, ("rewards", "motion_seconds", "motion_joules", "path")),
                              (FLEET, ("rewards", "battery", "seconds", "joules", "contacts")))
          for name in names for value in (np.nan, np.inf, -np.inf, 1.1e12)],
        *[(LONE, "motion_seconds", 1, value, AMOUNTS) for value in (0.0, -1.0)],
        (LONE, "motion_joules", 1, -1.0, AMOUNTS),
        (FLEET, "seconds", (-1, 1), 0.0, AMOUNTS),
        (FLEET, "joules", (-1, 1), -1.0, AMOUNTS),
        (LONE, "cells", 9, (0, 0), "cells: row 0, column 0 is wall"),
        (LONE, "cells", 9, (7, 1), "cells: row 7, column 1 is off the grid"),
        (LONE, "cells", 9, (2**31 - 1, 1), "cells: row 2147483647, column 1 is off the grid"),
        (FLEET, "cells", (-1, 1), -1, "cells: row -1, column "),
        (FLEET, "cells", (-1, 1), 0, "cells: row 0, column 0 is wall"),
        (FLEET, "people", (-1, 1), 10**6, "is off the grid"),
        (FLEET, "people", (-1, 1), 0, "people: row 0, column 0 is wall"),
        (LONE, "motion_cells", 2, (0, 0), "the motions do not end in the recorded cells"),
        (FLEET, "motion_cells", (0, 0), 0, "the motions do not end in the recorded cells"),
        (FLEET, "motion_cells", (-1, 1), 0, "the motions do not end in the recorded cells"),
        (FLEET, "actions", (-1, 1), 8, "actions: a number is outside 0..7"),
        (FLEET, "actions", (-1, 1), -1, "actions: a number is outside 0..7"),
        (FLEET, "stopped_by", (-1, 1), -3, "stopped_by: a number is outside -2..5"),
        (FLEET, "stopped_by", (-1, 1), 6, "stopped_by: a number is outside -2..5"),
        (LONE, "contact_counterparts", -1, -1, "counterparts has a code outside"),
        (LONE, "contact_counterparts", -1, 9, "counterparts has a code outside"),
        (LONE, "actions", 0, -1, "actions has a code outside"),
    ],
)  # fmt: skip
def test_impossible_values_are_refused(refused, kind, name, place, value, message) -> None:
    assert message in refused(kind, **{name: changed_at(arrays_of(kind)[name], place, value)})


@pytest.mark.parametrize(
    ("name", "value", "least"),
    [("path_lengths", 1, 2), ("path_lengths", -2, 2), ("contact_counts", -1, 0)],
)
def test_a_motion_has_a_path_and_no_negative_number_of_contacts(
    refused: Refused, name: str, value: int, least: int
) -> None:
    counts = arrays_of(LONE)[name].copy()
    counts[1] += counts[0] - value
    counts[0] = value
    assert f"{name} has a number below {least}" in refused(LONE, **{name: counts})


def test_the_sum_of_very_long_paths_does_not_overflow(refused: Refused) -> None:
    lengths = np.full(20, 2**31 - 1, "<i4")
    assert f"it must be ({20 * (2**31 - 1)}, 4)" in refused(LONE, path_lengths=lengths)


@pytest.mark.parametrize("kind", [LONE, FLEET])
def test_a_record_that_becomes_too_many_objects_is_refused(refused, monkeypatch, kind) -> None:
    changed = {} if kind == LONE else {"assignments": np.zeros((3, 3), "<i4")}
    arrays = arrays_of(kind) | changed
    others = ["cells"] if kind == LONE else ["orders", "assignments"]
    parts = [len(arrays[name]) for name in ("motion_cells", "contacts", *others)]
    assert min(parts) > 0
    objects = sum(parts)
    monkeypatch.setattr(arrays_module, "MAX_OBJECTS", objects)
    unpack(arrays)
    monkeypatch.setattr(arrays_module, "MAX_OBJECTS", objects - 1)
    assert f"have {objects} rows; at most {objects - 1} are allowed" in refused(kind, **changed)


RELEASED, DUE, PICKUP, DROPOFF, ROBOT, TAKEN_BY, TAKEN, DELIVERED = 0, 1, 2, 4, 6, 7, 8, 9


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({RELEASED: -1}, "order 0 is released before step 0"),
        ({RELEASED: 31, DUE: 40}, "order 0 is released before step 0 or after the last"),
        ({DUE: 0}, "or due before"),
        ({PICKUP: -1}, "the pickup of an order: row -1"),
        ({DROPOFF + 1: 99}, "the dropoff of an order: row "),
        ({PICKUP: 0}, "the pickup of an order: row 0"),
        ({ROBOT: 4}, "assigned to or taken by a robot that does not exist"),
        ({TAKEN_BY: -2}, "assigned to or taken by a robot that does not exist"),
        ({TAKEN_BY: -1}, "or by no robot"),
        ({TAKEN: -1, DELIVERED: -1}, "or by no robot"),
        ({TAKEN: 31}, "after the last step"),
        ({RELEASED: 5}, "taken before its release"),
        ({DELIVERED: 3}, "delivered before it was taken"),
        ({DELIVERED: 31}, "or after the last step"),
    ],
)
def test_impossible_orders_are_refused(refused, changes, message) -> None:
    orders = arrays_of(FLEET)["orders"].copy()
    orders[0, [RELEASED, DUE]], orders[0, ROBOT:] = (1, 9), (-1, 1, 4, 7)
    orders[0, list(changes)] = list(changes.values())
    assert message in refused(FLEET, orders=orders)


def test_orders_at_the_limits_of_an_episode_are_read() -> None:
    arrays = arrays_of(FLEET)
    pickup_and_dropoff = arrays["orders"][0, PICKUP:ROBOT].tolist()
    limits = [
        (0, 0, *pickup_and_dropoff, -1, 0, 0, 0),
        (0, 30, *pickup_and_dropoff, 3, 3, 30, 30),
        (30, 30, *pickup_and_dropoff, 0, 2, 30, -1),
        (30, 30, *pickup_and_dropoff, 3, -1, -1, -1),
    ]
    read = unpack(arrays | {"orders": np.array(limits), "assignments": np.zeros((0, 3))})
    found = [
        (each.released, each.due, each.robot, each.taken_by, each.taken, each.delivered)
        for each in read["orders"]
    ]
    assert found == [
        (0, 0, None, 0, 0, 0),
        (0, 30, 3, 3, 30, 30),
        (30, 30, 0, 2, 30, None),
        (30, 30, 3, None, None, None),
    ]


@pytest.mark.parametrize(
    ("assignment", "message"),
    [
        ([31, 0, 0], "steps of assignments: a number is outside 0..30"),
        ([0, 4, 0], "robots of assignments: a number is outside 0..3"),
        ([0, 0, 10**6], "orders of assignments: a number is outside -1.."),
    ],
)
def test_impossible_assignments_are_refused(refused, assignment, message) -> None:
    assert message in refused(FLEET, assignments=np.array([assignment], np.int32))


# The layout.


def test_a_byte_that_is_no_letter_is_refused(refused: Refused) -> None:
    refused(LONE, layout=changed_at(arrays_of(LONE)["layout"], (2, 3), 0xFF))


def test_a_charger_is_a_tile_and_other_robots_and_people_are_none(refused: Refused) -> None:
    arrays = arrays_of(LONE)
    tiles = arrays["layout"]
    assert unpack(arrays | {"layout": changed_at(tiles, (2, 5), ord("C"))})
    for character in "OoHcR":
        message = refused(LONE, layout=changed_at(tiles, (2, 5), ord(character)))
        assert f"row 2, column 5: {character!r} is not a tile" in message
        assert "C (charger)" in message


@pytest.mark.parametrize(
    ("layout", "message"),
    [
        *[(np.zeros(shape, np.uint8), f"layout has the shape {shape}; it must have 1..{MAX_CELLS}")
          for shape in ((0, 12), (7, 0), (2**40, 0))],
        (np.full((MAX_CELLS + 1, 1), ord("."), np.uint8), f"it must have 1..{MAX_CELLS} tiles"),
        (np.full((MAX_ROWS + 1, 1), ord("?"), np.uint8), f"at most MAX_ROWS = {MAX_ROWS} are"),
    ],
    ids=["no rows", "no columns", "very many empty rows", "many cells", "many rows"],
)  # fmt: skip
def test_a_layout_of_another_size_is_refused_before_its_rows_are_made(
    refused: Refused,
    little_memory: Callable[[], AbstractContextManager[None]],
    layout: np.ndarray,
    message: str,
) -> None:
    arrays_of(LONE)
    with little_memory():
        assert message in refused(LONE, layout=layout)


# Files of version 0.1.

DATA = Path(__file__).parents[2] / "data"


def on_ice() -> Episode:
    ice = Disturbances(slippery=frozenset({(2, 3), (3, 4)}), grip=0.3, motor_strength=0.7)
    layout = DEFAULT_LAYOUT.with_chargers([(1, 1), (5, 10)])
    backend = RigidBodyMotion(disturbances=ice)
    env = WarehouseEnv(layout, max_steps=8, battery=20, backend=backend)
    return record_episode(env, GreedyAgent(0), seed=3)


def outcomes_of(record: Episode) -> list[Outcome]:
    if not record.is_fleet:
        return list(record.motions)
    return [outcome for step in record.motions for outcome in step]


@pytest.mark.parametrize(
    ("name", "again"),
    [
        ("episode-0.1.npz", on_ice),
        ("fleet-0.1.npz", lambda: fleet_episode(backend="physics", max_steps=6)),
        ("driving-0.1.npz", lambda: fleet_episode(backend="driving", max_steps=9, people=0)),
    ],
)
def test_files_of_version_0_1_are_read_and_written(name, again, tmp_path) -> None:
    loaded = Episode.load(DATA / name)
    # Version 0.1 had no drive and no readings, and its headings lagged behind the motion.
    pairs = zip(outcomes_of(loaded), outcomes_of(again()), strict=True)
    for old, new in pairs:
        assert old.readings is None
        assert np.array_equal(old.path[:, :3], new.path[:, :3])
        assert old == new._replace(path=old.path, readings=None)
    newer = dataclasses.replace(again(), motions=loaded.motions)
    assert newer.drive == "omnidirectional"
    older = {"drive": ""} if newer.is_fleet else {
        "settings": dataclasses.replace(newer.settings, drive="")
    }  # fmt: skip
    assert loaded == dataclasses.replace(newer, **older)
    assert loaded.steps > 5
    loaded.save(tmp_path / name)
    with np.load(DATA / name) as old, np.load(tmp_path / name) as new:
        assert old.files == new.files
        assert all(old[each].tobytes() == new[each].tobytes() for each in old.files)
