"""Cached observations and masks equal those of the environment."""

import numpy as np
from helpers.gymnasium_envs import ROOM, plain

from warehouse_core import Layout, random_layout
from warehouse_core.task.rules import useful_actions

NORTH, EAST, SOUTH, WEST, WAIT, PICK, DROP = range(7)


def test_info_and_action_masks_return_equal_new_masks() -> None:
    env = plain(layout=random_layout(6, 6, 0.3, seed=1), max_steps=15)
    stream = np.random.default_rng(0)
    for episode in range(2):
        _, info = env.reset(seed=episode)
        over = False
        while not over:
            layout, state = env.warehouse.layout, env.warehouse.state
            row, col = state.robot_pos
            tile, sides = layout.rows[row][col], layout.open_sides((row, col))
            expected = list(useful_actions(sides, tile, state.has_item))
            for mask in (info["action_mask"], env.action_masks(), env.action_masks()):
                assert mask.tolist() == expected
                mask[:] = 3
            *_, terminated, truncated, info = env.step(int(stream.integers(7)))
            over = terminated or truncated


def test_the_layout_of_one_episode_has_its_own_walls() -> None:
    """Cached windows and masks of another layout are not used."""
    walled = Layout(["#####", "#P#D#", "#...#", "#####"])
    env = plain(layout=ROOM, randomize=False)
    env.reset()
    env.step(EAST)
    found, info = env.reset(options={"layout": walled})
    assert info["action_mask"].tolist() == [0, 0, 1, 0, 1, 1, 0]
    assert found["local_grid"].reshape(5, 5)[2].tolist() == [1, 1, 4, 1, 3]
    assert env.step(EAST)[0]["robot_pos"].tolist() == [1, 1]
    _, info = env.reset()
    assert info["action_mask"].tolist() == [0, 1, 1, 0, 1, 1, 0]
