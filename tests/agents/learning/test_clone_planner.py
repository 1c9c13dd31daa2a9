import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from helpers.networks import random_moves, random_traffic

from agents.errors import AgentError
from agents.lab.commands.planners.runs import make_stepper
from agents.learning.clone_planner import ClonePlanner
from agents.learning.traffic_network import TrafficNetwork
from agents.learning.traffic_view import SIZE
from agents.mapf.graph import Graph
from agents.mapf.lifelong import run_lifelong
from agents.mapf.planner import Situation, check_step
from agents.registry import make_agent, make_planner, make_solver
from warehouse_core import Layout, RecordError, random_layout

FLOOR = random_layout(9, 11, 0.2, seed=1)
DETOUR = 1
"""Place of the detour in a view."""


def shortest_ways(steep: float = 1.0) -> TrafficNetwork:
    """Return a network that prefers moves with a short way, and looks at nothing else."""
    layers = [
        (np.zeros((1, inputs), np.float32), np.zeros(1, np.float32)) for inputs in (SIZE, 1, 1)
    ]
    layers[0][0][0, DETOUR] = 1
    layers[1][0][0, 0] = 1
    layers[2][0][0, 0] = -steep
    return TrafficNetwork(False, layers)


def test_a_network_is_read_as_it_was_written(tmp_path: Path) -> None:
    network, path = random_traffic(1, lanes=True), tmp_path / "n.npz"
    network.save(path)
    read = TrafficNetwork.load(path)
    views = np.random.default_rng(2).random((6, 5, SIZE)).astype(np.float32)
    assert read.lanes is True
    assert np.array_equal(read.scores(views), network.scores(views))
    random_moves(1).save(path)
    with pytest.raises(RecordError, match=r"n\.npz"):
        TrafficNetwork.load(path)


def test_what_is_no_network_is_refused() -> None:
    layers = random_traffic(1).layers
    with pytest.raises(ValueError, match="layer 0 has the shapes"):
        TrafficNetwork(False, [(layers[0][0][:, 1:], layers[0][1]), *layers[1:]])
    with pytest.raises(TypeError, match="lanes"):
        TrafficNetwork(3, layers)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="network"):
        ClonePlanner("clone.npz", Graph(FLOOR))  # type: ignore[arg-type]


@pytest.mark.parametrize("seed", range(4))
def test_robots_never_collide_whatever_a_network_prefers(seed: int) -> None:
    graph, stream = Graph(FLOOR), np.random.default_rng(seed)
    planner = ClonePlanner(random_traffic(seed), graph, seed)
    cells = stream.permutation(FLOOR.open_cells)[:24]
    for _ in range(40):
        person = stream.choice(np.setdiff1d(FLOOR.open_cells, cells), 1)
        goals = stream.choice(FLOOR.open_cells, 24)
        situation = Situation(cells, goals, stream.random(24) < 0.1, person)
        cells = check_step(graph, situation, planner.next_cells(situation))


def test_robots_go_where_the_network_ranks_first() -> None:
    run = run_lifelong(Graph(FLOOR), ClonePlanner(shortest_ways(), Graph(FLOOR)), 6, 100, 1)
    away = run_lifelong(Graph(FLOOR), ClonePlanner(shortest_ways(-1), Graph(FLOOR)), 6, 100, 1)
    assert run.reached > 60 > 10 > away.reached


def test_who_is_surest_chooses_first_and_urgent_robots_before_all() -> None:
    """In a corridor to the right robots are sure; at its mouth two want the same cell."""
    graph = Graph(Layout(["#.###", "#....", "....#"]))
    cells, goals = np.array([1, 5 + 2, 2 * 5]), np.array([9, 9, 1])
    planner, none = ClonePlanner(shortest_ways(), graph), np.array([], int)
    stays = np.zeros(3, np.bool_)
    planner.next_cells(Situation(cells, goals, stays, none))
    views = planner.views
    keys = np.where(views[..., 0] > 0, views[..., DETOUR], np.inf)
    leads = np.diff(np.sort(keys, axis=1)[:, :2], axis=1)[:, 0]
    order = np.array(planner._team.order)
    assert (np.diff(leads[order]) <= 0).all()
    for urgent in range(3):
        planner.next_cells(Situation(cells, goals, stays, none, np.array([urgent])))
        assert planner._team.order[0] == urgent


def test_a_planner_is_made_by_the_name_of_its_file(tmp_path: Path) -> None:
    path, other = tmp_path / "n.npz", tmp_path / "other.npz"
    random_traffic(1, lanes=True).save(path)
    random_moves(1).save(other)
    planner = make_planner(f"clone:{path}", 3, FLOOR)
    assert isinstance(planner, ClonePlanner)
    assert planner.seed == 3
    assert planner.graph.costs is not None
    assert make_solver(f"clone:{path}", {}) is None
    stepper = make_stepper(f"clone:{path}", 1, FLOOR, 8, 5.0)
    assert len(run_lifelong(Graph(FLOOR), stepper, 8, 20, 1).seconds) == 20
    with pytest.raises(AgentError, match="planner clone needs what 'warehouse train clone' saves"):
        make_planner(f"clone:{other}")
    with pytest.raises(AgentError, match="agent clone needs what 'warehouse train clone' saves"):
        make_agent(f"clone:{path}")
    with pytest.raises(AgentError, match="planner 'clone:' names no file"):
        make_planner("clone:")
    with pytest.raises(AgentError, match=r"allowed: pibt.*, clone:FILE, or your own"):
        make_planner("clown")


def test_a_planner_runs_without_torch(tmp_path: Path) -> None:
    random_traffic(1).save(tmp_path / "n.npz")
    program = (
        "import sys; from agents.registry import make_planner; from warehouse_core import *; "
        "from agents.mapf.graph import Graph; from agents.mapf.lifelong import run_lifelong; "
        f"planner = make_planner('clone:{tmp_path / 'n.npz'}', 1); "
        "run_lifelong(Graph(DEFAULT_LAYOUT), planner, 3, 5, 1); sys.exit('torch' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", program]).returncode == 0
