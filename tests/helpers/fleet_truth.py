"""Fleets, compared with single warehouses and with other fleets."""

import random
from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np

from warehouse_core import Cell, FleetEnv, Layout, WarehouseEnv, random_layout
from warehouse_core.fleet import Battery, People
from warehouse_core.motion.backends import Backend
from warehouse_core.motion.traffic import find_stops
from warehouse_core.orders.order import OrderQueue
from warehouse_core.task.encoding import encode
from warehouse_core.task.rules import useful_actions
from warehouse_core.world import benchmark_warehouse
from warehouse_core.world.actions import DISPLACEMENTS
from warehouse_core.world.tiles import moved

NORTH, EAST, SOUTH, WEST, WAIT, PICK, DROP, FLY = range(8)


def plain(data: Any) -> Any:
    """Return nested data without arrays, which can be compared by ``==``."""
    if isinstance(data, np.ndarray):
        return str(data.dtype), data.tolist()
    if isinstance(data, dict):
        return {key: plain(value) for key, value in data.items()}
    if isinstance(data, (list, tuple)):
        return [plain(value) for value in data]
    return data


def state_of(fleet: FleetEnv) -> Any:
    """Return the visible state of a fleet."""
    arrays = [fleet.observe(robot) for robot in range(fleet.settings.robots)]
    orders = fleet.orders, fleet.open_orders, fleet.order_of
    seen = fleet.cells, fleet.loaded, fleet.battery, fleet.people, fleet.steps
    return arrays, orders, seen, repr(fleet.measures)


def lone_fleet(env: WarehouseEnv, backend: Backend = "grid") -> FleetEnv:
    """Return a fleet of one at the start of the same episode."""
    settings = env.settings
    fleet = FleetEnv(
        env.layout,
        1,
        backend=backend,
        starts=[env.state.robot_pos],
        max_steps=settings.max_steps,
        battery=settings.battery,
        view_radius=settings.view_radius,
    )
    arrays, info = fleet.reset()
    assert_sees(env, fleet, arrays, info)
    return fleet


def assert_steps_equal(env: WarehouseEnv, fleet: FleetEnv, action: Any) -> bool:
    """Step both, compare all results, and return whether the episode has ended."""
    _, reward, terminated, truncated, said = env.step(action)
    arrays, rewards, terminations, truncations, info = fleet.step([action])
    assert (rewards.tolist(), rewards.dtype) == ([reward], np.float64)
    assert terminations.tolist() == [terminated]
    assert truncations.tolist() == [truncated]
    assert info["invalid_action"].tolist() == [bool(said)]
    assert plain(fleet.last_motion) == plain([env.last_motion])
    assert info["motion"]["blocked"].tolist() == [env.last_motion.blocked]
    assert info["motion"]["seconds"].tolist() == [env.last_motion.seconds]
    assert info["motion"]["joules"].tolist() == [env.last_motion.joules]
    assert_sees(env, fleet, arrays, info)
    return terminated or truncated


def assert_sees(env: WarehouseEnv, fleet: FleetEnv, arrays: Any, info: Any) -> None:
    """Compare the observations in both forms, and the masks."""
    observation, seen = env.observe(), fleet.observe(0)
    row, col = env.state.robot_pos
    assert seen == observation
    encoded = encode(observation)
    assert set(encoded) == set(arrays)
    for key, value in encoded.items():
        each = arrays[key][0]
        assert np.array_equal(each, value), key
        assert each.dtype == np.asarray(value).dtype, key
    sides = tuple(env.layout.is_open((row + down, col + right)) for down, right in MOVES)
    mask = useful_actions(sides, env.layout.rows[row][col], env.state.has_item)
    assert (info["action_mask"].dtype, info["action_mask"].tolist()) == (np.int8, [[*mask]])


MOVES = ((-1, 0), (0, 1), (1, 0), (0, -1))


def charged_layout(height: int, width: int, chargers: int, seed: int) -> Layout:
    """Return a random layout with some chargers."""
    layout, stream = random_layout(height, width, 0.2, seed=seed), random.Random(seed)
    rows = [list(row) for row in layout.rows]
    empty = [(r, c) for r, row in enumerate(rows) for c, tile in enumerate(row) if tile == "."]
    for row, col in stream.sample(empty, min(chargers, len(empty))):
        rows[row][col] = "C"
    return Layout(["".join(row) for row in rows])


def random_lone_steps_equal(steps: int, seed: int, backend: Backend = "grid") -> int:
    """Compare random episodes in random layouts and settings; return the number of episodes."""
    stream, done, episodes = random.Random(seed), 0, 0
    while done < steps:
        height, width = stream.randint(4, 10), stream.randint(4, 10)
        layout = charged_layout(height, width, stream.randint(0, 3), stream.randint(0, 10**9))
        env = WarehouseEnv(
            layout,
            layout.open_cell(stream.randrange(len(layout.open_cells))),
            max_steps=stream.randint(1, 150),
            battery=stream.randint(1, 120),
            view_radius=stream.randint(0, 4),
            backend=backend,
        )
        fleet, ended, episodes = lone_fleet(env, backend), False, episodes + 1
        while not ended:
            ended = assert_steps_equal(env, fleet, helpful(env, stream))
            done += 1
    return episodes


def helpful(env: WarehouseEnv, stream: random.Random) -> Any:
    """Return a random action that often has an effect, or leads to the next station."""
    row, col = env.state.robot_pos
    tile = env.layout.rows[row][col]
    if stream.random() < 0.7 and tile in "PDC":
        return {"P": PICK, "D": DROP, "C": WAIT}[tile]
    if stream.random() < 0.5:
        to_row, to_col = (env.layout.dropoffs if env.state.has_item else env.layout.pickups)[0]
        return (WEST if to_col < col else EAST) if to_col != col else "N" if to_row < row else "S"
    return stream.choice([*range(8), "N", "e", "south"])


def bodies_move_as_the_grid(robots: int, joint_actions: int, seed: int = 0) -> Counter[str]:
    """Compare a fleet of bodies with a fleet on the grid, and count what stopped robots.

    Both have the same observations, rewards, flags and masks, and the same robots are blocked.
    """
    stream, stops, done = np.random.default_rng(seed), Counter[str](), 0
    while done < joint_actions:
        side = int(np.ceil(np.sqrt(robots * stream.uniform(1.5, 4)))) + 3
        layout = charged_layout(side, side + 1, 2, seed=int(stream.integers(10**9)))
        people = People(int(stream.integers(0, 1 + robots // 8)), pause=0.3)
        if len(layout.open_cells) < robots + people.count:
            continue
        settings: Any = {
            "orders": [None, 0.2, OrderQueue(robots)][stream.integers(3)],
            "battery": Battery(10**6),
            "people": people,
            "max_steps": min(100, joint_actions - done),
            "team_reward": bool(stream.integers(2)),
        }
        both = [FleetEnv(layout, robots, backend=each, **settings) for each in ("grid", "physics")]
        chance = int(stream.integers(10**9))
        seen = [fleet.reset(seed=chance) for fleet in both]
        assert plain(seen[0]) == plain(seen[1])
        ended = False
        while not ended:
            masks = seen[0][-1]["action_mask"]
            chosen = (stream.random(masks.shape) * [1, 1, 1, 1, 0.5, 1, 1]).argmax(axis=1)
            actions = np.where(masks[:, PICK], PICK, np.where(masks[:, DROP], DROP, chosen))
            seen = [fleet.step(actions) for fleet in both]
            mine, bodies = (plain(each[:4]) for each in seen)
            assert mine == bodies, (layout.rows, chance, both[0].steps)
            motions = [each[4]["motion"] for each in seen]
            assert np.array_equal(*(motion["blocked"] for motion in motions))
            assert plain(seen[0][4]["action_mask"]) == plain(seen[1][4]["action_mask"])
            stops.update(_kind_of(each, robots) for each in motions[0]["stopped_by"].tolist())
            done, ended = done + 1, bool((seen[0][2] | seen[0][3]).all())
        assert both[0].people == both[1].people
        assert both[0].orders == both[1].orders
        both[1].close()
    return stops


def _kind_of(stop: int, robots: int) -> str:
    return {-1: "free", -2: "wall"}.get(stop, "robot" if stop < robots else "person")


def big_warehouse(stations: str = "PPDC", count: int = 400) -> Layout:
    """Return 140 x 500 cells of shelves and aisles, with stations at random."""
    layout, stream = benchmark_warehouse(25, 34, 13, 2, 2), random.Random(0)
    rows = [list(row) for row in layout.rows]
    for number, rank in enumerate(stream.sample(range(len(layout.open_cells)), count)):
        row, col = layout.open_cell(rank)
        rows[row][col] = stations[number % len(stations)]
    return Layout(["".join(row) for row in rows])


def free_moves(
    layout: Layout, cells: Sequence[Cell], stream: np.random.Generator
) -> tuple[list[Cell], list[Cell]]:
    """Return random displacements that nothing stops, as from a planner, and the targets."""
    moves = [DISPLACEMENTS[action] for action in stream.integers(0, WAIT + 1, len(cells)).tolist()]
    while True:
        targets = list(map(moved, cells, moves))
        stops = find_stops(layout, cells, targets)
        if not any(stop is not None for stop in stops):
            return moves, targets
        moves = [
            (0, 0) if stop is not None else move for move, stop in zip(moves, stops, strict=True)
        ]
