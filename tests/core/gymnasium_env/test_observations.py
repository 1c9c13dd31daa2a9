"""Cached observations and masks equal the environment's own."""

from helpers.gymnasium_envs import ROOM, plain

from warehouse_core import Layout

NORTH, EAST, SOUTH, WEST, WAIT, PICK, DROP = range(7)


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
