import json
from dataclasses import asdict
from typing import Any

import pytest

from warehouse_core import Settings, WarehouseEnv
from warehouse_core.motion.base import Conditions
from warehouse_core.motion.grid import GridMotion

SETTINGS = Settings("grid", 0.5, (2, 3), 100, 50, 1, ((1, 2), (1, 3)), 0.5)


def as_json(settings: Settings) -> dict[str, Any]:
    return json.loads(json.dumps(asdict(settings)))


def test_settings_can_be_stored_as_json() -> None:
    assert Settings.from_json(as_json(SETTINGS)) == SETTINGS


def test_settings_are_those_of_the_environment() -> None:
    env = WarehouseEnv(start_pos=(2, 1), max_steps=9, battery=8, view_radius=0)
    assert env.settings == Settings("grid", 1.0, (2, 1), 9, 8, 0)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *[("max_steps", bad) for bad in (0, 1.0, True)],
        ("battery", 0),
        ("view_radius", -1),
        ("backend", 5),
        *[("cell_size", bad) for bad in (0.0, 1, float("nan"), float("inf"))],
        *[("motor_strength", bad) for bad in (1, -0.1, 1.1, float("nan"), "weak")],
        *[("slippery", bad) for bad in ("11", None, [5], [[1]], [[1, 2.0]], {"a": 1})],
        *[("drive", bad) for bad in (None, 2)],
        *[("start_pos", bad) for bad in ("11", [1, 1, 1], [1.0, 1], [True, 1])],
    ],
)
def test_the_error_of_an_invalid_value_names_it(name: str, value: object) -> None:
    with pytest.raises(ValueError, match=f"{name} is"):
        Settings.from_json(as_json(SETTINGS) | {name: value})


@pytest.mark.parametrize("values", [None, {"battery": 5}, asdict(SETTINGS) | {"colour": "red"}])
def test_other_keys_raise(values: object) -> None:
    with pytest.raises(ValueError, match="must have the keys backend, cell_size"):
        Settings.from_json(values)


def test_settings_of_older_records_are_nominal() -> None:
    values = as_json(SETTINGS)
    del values["slippery"], values["motor_strength"], values["drive"]
    assert "drive" not in SETTINGS.to_json()
    assert Settings.from_json(values) == Settings("grid", 0.5, (2, 3), 100, 50, 1)


def test_the_conditions_of_a_motion_are_recorded_where_the_floor_is_open() -> None:
    class IcyMotion(GridMotion):
        conditions = Conditions(((2, 1), (0, 0), (1, 1), (99, 1)), 1, "tracked")

    settings = WarehouseEnv(backend=IcyMotion()).settings
    assert (settings.slippery, settings.motor_strength) == (((1, 1), (2, 1)), 1.0)
    assert settings.drive == "tracked"
    assert Settings.from_json(as_json(settings)) == settings
