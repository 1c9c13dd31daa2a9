"""The tests that PettingZoo ships, with every warning an error."""

import warnings
from functools import partial
from typing import Any
from unittest.mock import Mock

import pytest

with warnings.catch_warnings():
    # The tests import one of PettingZoo's own games by a deprecated path.
    warnings.simplefilter("ignore", DeprecationWarning)
    from pettingzoo.test import (
        api_test,
        max_cycles_test,
        parallel_api_test,
        parallel_seed_test,
        render_test,
        seed_test,
    )

from warehouse_core import Layout, pettingzoo_env

YARD = Layout(["........", ".P.##.D.", "...##...", ".C....P."])
SETTINGS: list[dict[str, Any]] = [
    {},
    {"layout": YARD, "robots": 3, "orders": 0.3, "max_cycles": 60, "people": 2},
    {"layout": YARD, "robots": 4, "orders": 0.1, "max_cycles": 80, "battery": 25},
    {"layout": YARD, "robots": 3, "orders": 0.3, "max_cycles": 60, "moves": "turn"},
]
"""Robots that end together or one after the other, and robots with headings."""

NOT_LISTED = "Observation is not a NumPy array|Observation space for each agent probably should be"
"""Warning of ``api_test`` about every ``Dict``, except in PettingZoo's own environments."""


@pytest.fixture(params=range(len(SETTINGS)))
def settings(request: pytest.FixtureRequest) -> dict[str, Any]:
    return SETTINGS[request.param]


@pytest.fixture(autouse=True)
def no_supply_warning() -> Any:
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "1 charger can keep")
        yield


@pytest.mark.parametrize("observation", ["dict", "vector", "image"])
def test_parallel_api(settings: dict[str, Any], observation: str) -> None:
    parallel_api_test(pettingzoo_env.parallel_env(observation=observation, **settings), 200)


@pytest.mark.parametrize("observation", ["dict", "vector"])
def test_api(settings: dict[str, Any], observation: str) -> None:
    if observation == "dict":
        warnings.filterwarnings("ignore", NOT_LISTED)
    api_test(pettingzoo_env.env(observation=observation, **settings), 200)


def test_seeds(settings: dict[str, Any]) -> None:
    seed_test(partial(pettingzoo_env.env, **settings), 200)
    parallel_seed_test(partial(pettingzoo_env.parallel_env, **settings), 200)


def test_max_cycles() -> None:
    max_cycles_test(pettingzoo_env)


def test_pictures(settings: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DISPLAY", ":0")  # never opened
    window = Mock()
    monkeypatch.setattr(
        "warehouse_core.pettingzoo_env.parallel.PictureWindow", Mock(return_value=window)
    )
    render_test(partial(pettingzoo_env.env, **settings))
    assert len({call.args[0].tobytes() for call in window.show.call_args_list}) > 1
