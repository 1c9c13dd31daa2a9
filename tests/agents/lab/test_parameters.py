"""Parameters: valid values, and errors for invalid values that list what is allowed."""

import math

import pytest

from agents.errors import ParameterError
from agents.lab.parameters import (
    MAX_VALUE,
    MAX_VIEW_RADIUS,
    PARAMETERS,
    checked,
    field_defaults,
    find,
)
from warehouse_core.batch.fleet_settings import MAX_BODIES
from warehouse_core.world.generators import MAX_DENSITY
from warehouse_physics import Disturbances, RobotSpec

VALID = {
    "robots": [1, MAX_BODIES],
    "planner": ["none", "pibt", "mine.py:Mine"],
    "assignment": ["fifo", "urgent"],
    "order_rate": [0, 0.3, 5],
    "due": ["0:0", "50:150"],
    "chargers": [0, 4],
    "people": [0, MAX_BODIES],
    "agent": ["greedy", "mine.py:Mine"],
    "escape": [True, False],
    "memory": [0, 1, MAX_VALUE],
    "layout": ["default", "random", "hall.txt"],
    "size": ["4x4", "7x12", "9999x9999"],
    "stations": ["drawn", "kept"],
    "density": [0, 0.2, MAX_DENSITY],
    "battery": [1, MAX_VALUE],
    "max_steps": [1, MAX_VALUE],
    "view_radius": [0, MAX_VIEW_RADIUS],
    "backend": ["grid", "physics"],
    "robot.mass": [70, 1.5, -1],
}
INVALID = {
    "robots": [0, MAX_BODIES + 1, 2.0, True],
    "planner": ["", 3],
    "assignment": ["none", "", 3],
    "order_rate": [-0.1, math.inf, "0.1"],
    "due": ["150:50", "50", "50:150:200", " 5:9", "-1:9", 50],
    "chargers": [-1, 1.0],
    "people": [-1, MAX_BODIES + 1],
    "agent": ["", " ", 3, None],
    "escape": [1, 0, "true", None],
    "memory": [-1, MAX_VALUE + 1, 1.0, True, "1"],
    "layout": ["", 3],
    "size": ["3x4", "4x3", "7X12", "07x12", "7x12 ", "10000x4", 7, "7x12\n"],
    "stations": ["Kept", "", True, None],
    "density": [-0.01, MAX_DENSITY + 0.01, math.nan, "0.2", True],
    "battery": [0, MAX_VALUE + 1, 1.5],
    "max_steps": [0, MAX_VALUE + 1, False],
    "view_radius": [-1, MAX_VIEW_RADIUS + 1],
    "backend": ["hover", "", 3],
    "robot.mass": [math.nan, math.inf, -math.inf, 10**400, "70", True],
}


def test_the_values_above_cover_every_parameter() -> None:
    assert VALID.keys() == INVALID.keys() == PARAMETERS.keys() | {"robot.mass"}


@pytest.mark.parametrize("name", VALID)
def test_an_allowed_value_is_stored_unchanged(name: str) -> None:
    for value in [*VALID[name], find(name).default]:
        assert checked(name, value) == value
    assert type(checked("density", 0)) is type(checked("robot.mass", 70)) is float


@pytest.mark.parametrize("name", INVALID)
def test_an_invalid_value_is_an_error_that_names_the_parameter(name: str) -> None:
    for value in INVALID[name]:
        with pytest.raises(ParameterError) as caught:
            checked(name, value)
        assert str(caught.value).startswith(f"{name} is {value!r}; allowed: ")


@pytest.mark.parametrize(("group", "kind"), [("robot", RobotSpec), ("disturbances", Disturbances)])
def test_the_parameters_of_a_group_are_the_numbers_of_its_class(group: str, kind: type) -> None:
    numbers = field_defaults(group)
    assert numbers
    for name, default in numbers.items():
        assert getattr(kind(), name) == default
        assert find(f"{group}.{name}").default == default


@pytest.mark.parametrize("name", ["batery", "robot", "robot.mas", "a.b"])
def test_an_unknown_name_is_an_error_that_lists_the_allowed_ones(name: str) -> None:
    with pytest.raises(ParameterError, match="allowed: ") as caught:
        find(name)
    assert repr(name) in str(caught.value) or name.startswith("robot")
