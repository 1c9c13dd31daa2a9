from collections.abc import Mapping
from importlib.metadata import EntryPoint
from types import MappingProxyType, SimpleNamespace
from typing import Any

import pytest

from warehouse_core import BackendError, FleetEnv, Layout, WarehouseEnv
from warehouse_core.motion.backends import (
    GROUP,
    backend_names,
    make_batch_motion,
    make_fleet_motion,
    make_motion,
)
from warehouse_core.motion.base import BaseBatchMotion, Conditions, Routes, with_defaults
from warehouse_core.motion.grid import GridBatch, GridFleetBatch, GridMotion
from warehouse_core.motion.separate import SeparateMotions


class FakeDistribution:
    """The distribution of an entry point."""

    def __init__(self, name: str, requires: list[str] | None) -> None:
        self.metadata = {"Name": name}
        self.requires = requires


def entry_point(name: str, value: str, distribution: Any = None) -> EntryPoint:
    point = EntryPoint(name, value, GROUP)
    vars(point).update(dist=distribution)
    return point


def test_an_environment_accepts_all_three_and_names_them() -> None:
    assert WarehouseEnv(backend="grid").backend == "grid"
    assert WarehouseEnv(backend=GridMotion).backend == "GridMotion"
    env = WarehouseEnv(backend=GridMotion(cell_size=0.5))
    assert (env.backend, env.settings.cell_size) == ("GridMotion", 0.5)


def test_the_error_of_an_unknown_name_lists_the_installed_ones(install: Any) -> None:
    install(entry_point("rails", "no.such:Rails"), entry_point("grid", "no.such:Grid"))
    with pytest.raises(BackendError, match="no backend is called 'boat'; installed: grid, rails"):
        make_motion("boat")
    install()
    with pytest.raises(BackendError, match="installed: none"):
        make_motion("grid")


@pytest.mark.parametrize(
    ("distribution", "command"),
    [
        (
            FakeDistribution("a", ["b>=1", "c<8,>=7.1; extra == 'physics'", "d; extra == 'test'"]),
            "'c<8,>=7.1'",
        ),
        (FakeDistribution("other-lab", ["d; extra == 'test'"]), "'other-lab'"),
        (FakeDistribution("other-lab", None), "'other-lab'"),
        (None, "'missing_engine'"),
    ],
)
def test_the_error_of_a_missing_requirement_gives_the_command(
    install: Any, distribution: Any, command: str
) -> None:
    install(entry_point("physics", "missing_engine.motion:Motion", distribution))
    with pytest.raises(BackendError) as caught:
        WarehouseEnv(backend="physics")
    assert str(caught.value) == (
        "backend 'physics' needs missing_engine, which is not installed: pip install " + command
    )
    assert isinstance(caught.value.__cause__, ImportError)


@pytest.mark.parametrize("backend", [None, dict, b"grid"])
def test_a_backend_of_another_type_raises(backend: Any) -> None:
    with pytest.raises(TypeError, match=r"allowed: a name \(.*grid.*\), or a class or instance"):
        WarehouseEnv(backend=backend)


class WithoutBatch:
    """A motion with only the required parts."""

    cell_size = 1.0

    def reset(self, layout: Any, cells: Any, seed: Any) -> None:
        raise NotImplementedError

    advance = close = reset


class LoneBatch(GridMotion):
    """A grid without array motion of fleets."""

    def fleet_batch(self, layouts: Any, robots: int) -> Any:
        raise ValueError("lone robots only")


@pytest.mark.parametrize("robots", [1, 2])
def test_fleets_of_one_robot_and_more_are_moved_by_arrays_if_the_backend_can(robots: int) -> None:
    layouts = [Layout(["..."])] * 2
    for backend in ("grid", GridMotion, GridMotion()):
        assert type(make_fleet_motion(backend, layouts, robots)) is GridFleetBatch
    for backend in (LoneBatch, WithoutBatch):
        made = make_fleet_motion(backend, layouts, robots)
        assert type(made) is SeparateMotions
        assert len({id(motion) for motion in made._motions}) == 2
    lone = WithoutBatch()
    [motion] = make_fleet_motion(lone, layouts[:1], robots)._motions
    assert motion.advance.__self__ is lone
    with pytest.raises(BackendError, match=r"is a single motion.*2 layouts need the name or the"):
        make_fleet_motion(LoneBatch(), layouts, robots)


def test_a_motion_with_four_members_has_defaults_for_the_rest() -> None:
    lone, grid = WithoutBatch(), GridMotion(cell_size=0.5)
    motion = with_defaults(lone)
    assert (motion.advance, motion.cell_size) == (lone.advance, 1.0)
    assert (motion.conditions, motion.cell_steps, motion.cell_joules) == (Conditions(), 1.0, None)
    assert not motion.drives_through
    assert motion.routes() == Routes((), (), ())
    assert motion.face([]) is motion.fail(0) is motion.scan(0, 4) is motion.odometry(0) is None
    batch = with_defaults(SimpleNamespace(place=lone.reset, close=lone.close), BaseBatchMotion)
    assert (batch.place, batch.changes_layouts, batch.outcomes(0)) == (lone.reset, False, ())
    assert with_defaults(grid) is grid


def test_a_batch_of_lone_robots_needs_a_backend_that_has_one() -> None:
    assert type(make_batch_motion(LoneBatch, [Layout(["..."])])) is GridBatch
    with pytest.raises(BackendError, match=r"cannot move a batch; .* a method batch\(layouts\)"):
        make_batch_motion(WithoutBatch, [Layout(["..."])])


class Slower(GridMotion):
    """A grid whose robots do not move, but move in its batches."""

    def advance(self, displacements: Any, loaded: Any) -> Any:
        return super().advance([(0, 0)] * len(displacements), loaded)


def test_batches_that_are_inherited_without_their_advance_are_not_used() -> None:
    with pytest.raises(BackendError, match=r"batch\(layouts\) for its own advance\(\)"):
        make_batch_motion(Slower, [Layout(["..."])])
    env = FleetEnv(["...."], 2, starts=[(0, 0), (0, 2)], backend=Slower)
    env.reset(seed=0)
    env.step(["WAIT", "E"])
    assert env.cells == [(0, 0), (0, 2)]


class Numbered(GridMotion):
    """A backend that takes numbers."""

    numbers: Mapping[str, float] = MappingProxyType({})

    @classmethod
    def from_numbers(cls, numbers: Mapping[str, float]) -> "Numbered":
        if numbers.get("speed", 0) < 0:
            raise ValueError(f"speed is {numbers['speed']}; it must be above 0")
        motion = cls()
        motion.numbers = numbers
        return motion


def test_numbers_may_follow_the_name_of_a_backend(install) -> None:
    install(entry_point("numbered", f"{__name__}:Numbered"))
    assert backend_names() == ["numbered"]
    motion = make_motion("numbered:speed=2,mass=1e2")
    assert isinstance(motion, Numbered)
    assert motion.numbers == {"speed": 2.0, "mass": 100.0}
    assert make_motion("numbered").numbers == {}  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("numbers", "message"),
    [
        ("speed=-1", "speed is -1.0; it must be above 0"),
        ("speed=fast", "'speed=fast' is not of the form name=1.5"),
        ("speed", "'speed' is not of the form name=1.5"),
        ("", "'' is not of the form name=1.5"),
        ("speed=1,", "'' is not of the form name=1.5"),
    ],
)
def test_numbers_that_a_backend_does_not_take_are_named(install, numbers, message) -> None:
    install(entry_point("numbered", f"{__name__}:Numbered"))
    with pytest.raises(BackendError) as raised:
        make_motion(f"numbered:{numbers}")
    assert str(raised.value) == f"backend 'numbered:{numbers}': {message}"


def test_a_backend_without_numbers_says_so() -> None:
    with pytest.raises(BackendError, match=r"^backend 'grid' takes no numbers; 'a=1' was given$"):
        make_motion("grid:a=1")
    with pytest.raises(BackendError, match=r"^no backend is called 'sleigh'; installed: "):
        make_motion("sleigh:a=1")
