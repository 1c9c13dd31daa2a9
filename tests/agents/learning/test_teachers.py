import numpy as np

from agents.learning.teachers import AgentTeacher, ShortestPaths
from agents.search.agents import ExploringAgent
from warehouse_core import BatchEnv, Layout, random_layout
from warehouse_core.fleet.observation import observation_of
from warehouse_core.world.actions import ACTIONS
from warehouse_core.world.distances import distances
from warehouse_core.world.tiles import MOVE_DELTAS, moved


def test_each_first_move_of_a_shortest_path_is_right_and_no_other() -> None:
    batch = BatchEnv(20, random_layout(8, 9, 0.2, seed=1), autoreset_mode="SameStep")
    arrays, _ = batch.reset(seed=1)
    teacher, stream = ShortestPaths(batch), np.random.default_rng(2)
    teacher.begin(np.arange(20), arrays)
    chosen = 0
    for _ in range(60):
        right = teacher.moves(arrays)
        for row in range(20):
            layout, state = batch.row(row)
            goal = arrays["dropoff_pos" if state.has_item else "pickup_pos"][row].tolist()
            steps = distances(layout, [(goal[0], goal[1])])
            here = state.robot_pos
            expected = [
                bool(steps[moved(here, delta)] < steps[here]) for delta in MOVE_DELTAS.values()
            ]
            assert right[row].tolist() == expected
            chosen += sum(expected)
        masks = batch.action_masks()
        actions = np.where(right.any(1), right.argmax(1), 6 - masks[:, ::-1].argmax(1))
        wild = stream.random(20) < 0.2
        actions[wild] = masks[wild].argmax(1)
        arrays, _, terminated, truncated, _ = batch.step(actions)
        teacher.begin(np.flatnonzero(terminated | truncated), arrays)
    assert chosen > 500


def test_an_agent_teaches_what_it_would_do() -> None:
    layout = random_layout(8, 9, 0.3, seed=1)
    batch = BatchEnv(3, layout, autoreset_mode="SameStep")
    made: list[Layout] = []

    def make(given: Layout) -> ExploringAgent:
        made.append(given)
        return ExploringAgent()

    arrays, _ = batch.reset(seed=1)
    teacher = AgentTeacher(batch, make)
    teacher.begin(np.arange(3), arrays)
    agents = [ExploringAgent() for _ in range(3)]
    for _ in range(12):
        right = teacher.moves(arrays)
        actions = [agent.act(observation_of(arrays, row)) for row, agent in enumerate(agents)]
        expected = [[word == action for word in MOVE_DELTAS] for action in actions]
        assert right.tolist() == expected
        arrays, _, terminated, truncated, _ = batch.step([ACTIONS.index(a) for a in actions])
        for row in np.flatnonzero(terminated | truncated).tolist():
            agents[row] = ExploringAgent()
        teacher.begin(np.flatnonzero(terminated | truncated), arrays)
    assert made[0] == batch.layouts.kinds[0]
