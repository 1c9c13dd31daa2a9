"""``gymnasium.make`` finds the environments after ``import warehouse_core``."""

import importlib
import subprocess
import sys
from types import ModuleType, SimpleNamespace
from typing import Any
from unittest.mock import Mock

import pytest

from warehouse_core import registration
from warehouse_core.registration import GOAL_ID, ID, AfterGymnasium, register


@pytest.mark.parametrize("first", ["gymnasium, warehouse_core", "warehouse_core, gymnasium"])
def test_the_names_are_known_whatever_is_imported_first(first: str) -> None:
    program = f"import {first}; [gymnasium.make(name) for name in {ID, GOAL_ID}]"
    subprocess.run([sys.executable, "-W", "error", "-c", program], check=True)


def found(monkeypatch: pytest.MonkeyPatch, spec: Any) -> Any:
    """Return the spec that the finder finds for Gymnasium, and check that the finder is removed."""
    finder = AfterGymnasium()
    monkeypatch.setattr(sys, "meta_path", [finder, *sys.meta_path])
    monkeypatch.setattr(registration, "find_spec", {"gymnasium": spec}.get)
    assert finder.find_spec("gymnasium_robotics", None) is None
    assert finder in sys.meta_path
    result = finder.find_spec("gymnasium", None)
    assert finder not in sys.meta_path
    return result


def test_the_names_are_registered_at_the_end_of_the_import(monkeypatch: pytest.MonkeyPatch) -> None:
    calls, execute = Mock(), Mock()
    calls.attach_mock(execute, "execute")
    spec = found(monkeypatch, SimpleNamespace(loader=SimpleNamespace(exec_module=execute)))
    spec.loader.exec_module(calls)
    assert [call[0] for call in calls.mock_calls] == ["execute", "register", "register"]
    assert [call[1][:1] for call in calls.mock_calls[1:]] == [(ID,), (GOAL_ID,)]


def test_without_gymnasium_nothing_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    assert found(monkeypatch, None) is None


def test_the_finder_waits_only_if_gymnasium_is_not_there(monkeypatch: pytest.MonkeyPatch) -> None:
    fake = ModuleType("gymnasium")
    monkeypatch.setattr(fake, "register", Mock(), raising=False)
    monkeypatch.setattr(sys, "meta_path", sys.meta_path.copy())
    monkeypatch.setitem(sys.modules, "gymnasium", fake)
    before = sys.meta_path.copy()
    importlib.reload(registration)
    assert sys.meta_path == before
    assert fake.register.call_count == 2
    monkeypatch.delitem(sys.modules, "gymnasium")
    importlib.reload(registration)
    assert type(sys.meta_path[0]).__name__ == AfterGymnasium.__name__
    assert register.__module__ == registration.__name__
