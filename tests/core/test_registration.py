import importlib
import subprocess
import sys
from importlib.util import find_spec
from types import ModuleType
from unittest.mock import Mock

import pytest

from warehouse_core import registration
from warehouse_core.registration import DRIVE_ID, GOAL_ID, ID, AfterGymnasium, Registering, register

FORGET = "[sys.modules.pop(name) for name in [*sys.modules] if name.split('.')[0] == {!r}]"

ORDERS = {
    "Gymnasium first": "import gymnasium, warehouse_core",
    "looked up": (
        "import warehouse_core; from importlib.util import find_spec; find_spec('gymnasium');"
        "find_spec('gymnasium.envs'); import gymnasium; find_spec('gymnasium')"
    ),
    "Gymnasium imported again": (
        f"import warehouse_core, gymnasium; {FORGET.format('gymnasium')}; import gymnasium"
    ),
    "the core reloaded": (
        "import warehouse_core, importlib; importlib.reload(warehouse_core.registration);"
        "import gymnasium; importlib.reload(warehouse_core.registration)"
    ),
    "a lazy loader": (
        "import warehouse_core, importlib.util as util; spec = util.find_spec('gymnasium');"
        "spec.loader = util.LazyLoader(spec.loader); gymnasium = util.module_from_spec(spec);"
        "sys.modules['gymnasium'] = gymnasium; spec.loader.exec_module(gymnasium)"
    ),
}


@pytest.mark.parametrize("order", ORDERS)
def test_the_names_are_known_whatever_is_imported_first(order: str) -> None:
    program = f"import sys; {ORDERS[order]}; [gymnasium.spec(name) for name in {[ID, GOAL_ID]}];"
    program += "assert 'Registering' not in str(gymnasium.__loader__)"
    subprocess.run([sys.executable, "-W", "error", "-c", program], check=True)


def test_a_look_up_finds_all_that_the_ordinary_loader_has() -> None:
    spec = AfterGymnasium().find_spec("gymnasium", None)
    assert spec is not None
    assert spec.origin == importlib.import_module("gymnasium").__file__
    assert isinstance(spec.loader, Registering)
    assert "register" in spec.loader.get_source("gymnasium")
    assert spec.loader.create_module(spec) is None


def test_other_modules_are_left_to_the_ordinary_finders() -> None:
    assert AfterGymnasium().find_spec("gymnasium_robotics", None) is None


def test_a_name_is_registered_once() -> None:
    gymnasium = Mock(registry={ID: ""})
    register(gymnasium)
    assert [call.args for call in gymnasium.register.mock_calls] == [(GOAL_ID,), (DRIVE_ID,)]


@pytest.mark.parametrize("spec", [None, Mock(loader=None)])
def test_without_gymnasium_nothing_is_wrapped(spec: Mock, monkeypatch: pytest.MonkeyPatch) -> None:
    finder = Mock(find_spec=Mock(return_value=spec))
    monkeypatch.setattr(sys, "meta_path", [finder])
    assert AfterGymnasium().find_spec("gymnasium", None) is spec


def test_another_module_of_that_name_is_left_alone() -> None:
    fake = ModuleType("gymnasium")
    loader = Mock()
    Registering(loader).exec_module(fake)
    loader.exec_module.assert_called_once_with(fake)
    assert fake.__loader__ is loader


def test_there_is_one_finder_however_often_the_module_is_executed(monkeypatch) -> None:
    monkeypatch.setattr(sys, "meta_path", sys.meta_path.copy())
    importlib.reload(registration)
    names = [type(finder).__name__ for finder in sys.meta_path]
    assert names.count(AfterGymnasium.__name__) == 1
    assert find_spec("gymnasium") is not None
