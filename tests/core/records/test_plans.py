"""Checks of plans that are drawn beside a record."""

import re

import pytest
from helpers.fleets import LINE, fleet_episode

from warehouse_core.records.plans import NO_PLANS, StepPlans, check_plans


@pytest.mark.parametrize(
    ("plans", "said"),
    [
        ([NO_PLANS] * 5, "5 plans for 3 steps; allowed: at most 4"),
        ([NO_PLANS, StepPlans({2: []})], "plan 1: there is no robot 2; allowed: 0..1"),
        ([StepPlans(wishes={-1: []})], "plan 0: there is no robot -1"),
        ([StepPlans(pushers={0: 7})], "plan 0: there is no robot 7"),
        ([StepPlans({0: [(0, 2), (0, 9)]})], "plan 0: cell (0, 9) is not in the layout of 1 rows"),
        ([StepPlans(wishes={1: [(-1, 0)]})], "plan 0: cell (-1, 0) is not in the layout"),
    ],
)
def test_plans_must_be_those_of_the_episode(plans: list[StepPlans], said: str) -> None:
    episode = fleet_episode(layout=LINE, robots=2, people=0, orders=None, max_steps=3)
    check_plans([StepPlans({0: [(0, 8)]}, {1: [(0, 0)]}, {0: 1})] * 4, episode)
    with pytest.raises(ValueError, match=re.escape(said)):
        check_plans(plans, episode)
