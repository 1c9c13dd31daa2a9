"""Training of continuous control. Run with ``-m learning``."""

import numpy as np
import pytest

from warehouse_core import Layout

pytestmark = pytest.mark.learning

ROOM = Layout(["######", "#P..D#", "#....#", "######"])


def test_distances_go_around_walls():
    from agents.learning.drive_training import all_distances

    layout = Layout(["#####", "#.#.#", "#...#", "#####"])
    distances = all_distances(layout)
    assert distances[layout.number((1, 1)), layout.number((1, 3))] == 4
    assert np.isinf(distances[layout.number((1, 1)), layout.number((1, 2))])


def test_a_robot_comes_closer_along_the_shortest_path():
    from agents.learning.drive_training import ShapedRows

    rows = ShapedRows(ROOM, 1.0, seed=0)
    rows.reset()
    before = rows.potentials()
    goals, places = rows._batch.rows.goals(), rows._batch.rows.state.positions
    ahead = np.sign(np.round(goals - places)) * (0.5, 0.5)
    for _ in range(3):
        rows.step_async(ahead)
        _, _, done, _ = rows.step_wait()
    gained = (rows.potentials() - before)[~done]
    moves = (np.abs(goals - places).sum(axis=1) > 0.5)[~done]
    # While a robot drives diagonally, two paths are equally short, so the potential is constant.
    assert gained[moves].min() > -1e-6
    assert (gained[moves] > 0.1).mean() > 0.5


def test_a_short_training_learns_to_deliver_in_a_small_room(warehouse, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    ROOM.save("room.txt")
    result = warehouse("train", "drive", "--layout", "room.txt", "--steps", 400_000, "-o", "d.npz")
    assert result.code == 0
    [share] = [line for line in result.out.splitlines() if "delivered" in line]
    assert float(share.split("│")[2].strip(" %")) > 15  # without training it is almost 0
    run = warehouse("run", "--backend", "drive", "--agent", "drive:d.npz", "--layout", "room.txt",
                    "--seed", 1, "--no-show")  # fmt: skip
    assert run.code == 0
