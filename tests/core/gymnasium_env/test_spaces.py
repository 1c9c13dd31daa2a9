"""Observation spaces contain all observations, which reach their bounds."""

from functools import partial

import gymnasium
import numpy as np
import pytest
from helpers.gymnasium_envs import CORRIDOR, ROOM, make, make_vec, walk

from warehouse_core import Layout, random_layout
from warehouse_core.gymnasium_env.spaces import FORMS

over_forms = pytest.mark.parametrize("form", FORMS)


@over_forms
@pytest.mark.parametrize("layout", [CORRIDOR, ROOM, random_layout(9, 6, 0.2, seed=4)], ids=str)
def test_every_observation_is_in_its_space_up_to_its_limits(form: str, layout: Layout) -> None:
    limits = {"max_steps": 9, "battery": 12, "view_radius": 1}
    env = make(layout=layout, observation=form, **limits)
    for observation, *_ in walk(env, seed=1, steps=200):
        assert observation in env.observation_space
    space = env.observation_space
    if form == "vector":
        seen = np.stack([observation for observation, *_ in walk(env, seed=1, steps=2000)])
        corners = space.low < space.high
        assert (seen.min(axis=0) == space.low)[-3:].tolist() == [True, False, True]
        assert (seen.max(axis=0) == space.high)[-3:].tolist() == [True] * 3
        assert corners.all()


def test_spaces_have_the_documented_shapes_and_bounds() -> None:
    spaces = {form: make(observation=form, view_radius=1).observation_space for form in FORMS}
    flat = spaces["dict"]
    assert {key: space.shape for key, space in flat.items()} == {
        "local_grid": (9,),
        "robot_pos": (2,),
        "has_item": (),
        "battery": (1,),
        "steps": (1,),
        "pickup_pos": (2,),
        "dropoff_pos": (2,),
    }
    assert (flat["robot_pos"].low.tolist(), flat["robot_pos"].high.tolist()) == ([0, 0], [6, 11])
    assert flat["pickup_pos"].low.tolist() == [-1, -1]
    assert flat["steps"].high.tolist() == flat["battery"].high.tolist() == [200]
    assert spaces["vector"].shape == (3 * 9 + 11,)
    assert spaces["image"].shape == (64, 96, 3)
    assert make().action_space == gymnasium.spaces.Discrete(7)


@pytest.mark.parametrize("budget", ["battery", "max_steps"])
def test_budgets_above_int32_raise(budget: str) -> None:
    for made in (make, partial(make_vec, 2, "NextStep")):
        with pytest.raises(ValueError, match=f"{budget} is {2**31}; it must be at most"):
            made(**{budget: 2**31})
        made(**{budget: 2**31 - 1}).close()
