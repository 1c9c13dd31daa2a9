"""A fleet of one robot without orders is the chapter's warehouse."""

from typing import Any

import pytest
from helpers.fleet_truth import random_lone_steps_equal

from warehouse_core import FleetEnv


@pytest.mark.parametrize("backend", ["grid", "physics"])
def test_it_equals_random_episodes_with_chargers(backend: str) -> None:
    assert random_lone_steps_equal(600, seed=1, backend=backend) > 6


def test_the_default_start_equals_the_start_of_a_lone_robot() -> None:
    fleet: Any = FleetEnv(["#####", "#P..#", "#..D#", "#####"], 1)
    fleet.reset(seed=3)
    assert fleet.cells == [fleet.layout.default_start()]
