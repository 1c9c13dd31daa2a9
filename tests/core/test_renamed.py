"""Former names, which work and warn."""

import pytest

from warehouse_core import FleetEnv
from warehouse_core.renamed import Renamed
from warehouse_physics import DrivingMotion


def test_the_former_name_of_an_attribute_returns_the_new_one_and_warns_at_its_use() -> None:
    env = FleetEnv(robots=2)
    env.reset(seed=0)
    with pytest.warns(
        DeprecationWarning, match=r"^FleetEnv\.ways has been renamed to routes"
    ) as warned:
        former = env.ways
    assert former == env.routes
    assert warned[0].filename == __file__


def test_the_former_name_of_a_method_calls_the_new_one() -> None:
    motion = DrivingMotion()
    env = FleetEnv(robots=2, backend=motion)
    env.reset(seed=0)
    with pytest.warns(DeprecationWarning, match=r"^DrivingMotion\.ways has been renamed to routes"):
        former = motion.ways()
    assert former == env.routes


def test_the_former_name_in_a_class_prints_no_warning() -> None:
    assert isinstance(FleetEnv.ways, Renamed)
