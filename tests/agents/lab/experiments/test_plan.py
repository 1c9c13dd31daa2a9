"""Plans: every combination once, within limits, with seeds that can be stored."""

from typing import Any

import pytest

from agents.errors import ParameterError
from agents.lab.experiments.plan import (
    MAX_EPISODES,
    MAX_SEED,
    SweepPlan,
    make_plan,
    spread,
)


def values_of(name: str, plan: SweepPlan) -> list[Any]:
    return [case[name] for case in plan.cases]


def test_a_range_includes_its_end_in_spite_of_rounding() -> None:
    plan = make_plan({"density": {"from": 0, "to": 0.3, "step": 0.1}, "layout": "random"}, 1, 0)
    assert values_of("density", plan) == pytest.approx([0, 0.1, 0.2, 0.3])
    plan = make_plan({"battery": {"from": 20, "to": 59, "step": 20}}, 1, 0)
    assert values_of("battery", plan) == [20, 40]


def test_a_plan_has_at_most_max_cases(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("agents.lab.experiments.plan.MAX_CASES", 6)
    limits = {"from": 1, "to": 6, "step": 1}
    assert make_plan({"battery": limits}, 1, 0).total == 6
    with pytest.raises(ParameterError, match="battery has 7 values"):
        make_plan({"battery": limits | {"to": 7}}, 1, 0)


def test_a_parameter_without_a_value_is_an_error() -> None:
    with pytest.raises(ParameterError, match="battery has no value"):
        spread("battery", [])


def test_the_seeds_of_a_plan_are_consecutive() -> None:
    assert list(make_plan({}, 3, MAX_SEED).seeds) == [MAX_SEED, MAX_SEED + 1, MAX_SEED + 2]
    for seed in (-1, MAX_SEED + 1):
        with pytest.raises(ParameterError, match=rf"^seed is {seed}; .* 0\.\.{MAX_SEED}$"):
            make_plan({}, 1, seed)


def test_the_limit_of_episodes_is_for_all_cases_together() -> None:
    with pytest.raises(ParameterError, match="MAX_EPISODES"):
        make_plan({"battery": [20, 30]}, MAX_EPISODES // 2 + 1, 0)


def test_the_numbers_of_a_range_are_short_decimals() -> None:
    values = spread("density", {"from": 0, "to": 0.4, "step": 0.05})
    assert values == [0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4]
    assert str(spread("density", -0.0)) == "[0.0]"
