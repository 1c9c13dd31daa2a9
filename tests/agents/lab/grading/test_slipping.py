"""The slippery floor: directions and frequency of slips, and their seed."""

from collections import Counter

from agents.lab.grading.slipping import SlippingGrid
from warehouse_core import Layout, WarehouseEnv
from warehouse_core.conformance import run_conformance

OPEN = Layout(["." * 999] * 999)


def landings(chance: float, action: str, seed: int, count: int = 400) -> list[tuple[int, int]]:
    motion = SlippingGrid(chance)
    env, found = WarehouseEnv(OPEN, (499, 499), max_steps=count, battery=count, backend=motion), []
    env.reset(seed=seed)
    for _ in range(count):
        before = env.state.robot_pos
        row, column = env.step(action)[0]["robot_pos"]
        found.append((row - before[0], column - before[1]))
    return found


def test_a_move_goes_to_both_sides_as_often_as_the_chance_says_and_never_back() -> None:
    for action, ahead, sides in (
        ("N", (-1, 0), {(0, 1), (0, -1)}),
        ("E", (0, 1), {(1, 0), (-1, 0)}),
    ):
        counts = Counter(landings(0.4, action, seed=1))
        assert counts.keys() == {ahead, *sides}
        assert 200 < counts[ahead] < 280
        assert all(50 < counts[side] < 110 for side in sides)


def test_a_seed_repeats_and_waiting_does_not_slip() -> None:
    assert landings(0.5, "S", seed=3) == landings(0.5, "S", seed=3) != landings(0.5, "S", seed=4)
    assert set(landings(1.0, "WAIT", seed=1)) == {(0, 0)}
    assert set(landings(0.0, "W", seed=1)) == {(0, -1)}


def test_without_chance_it_is_a_backend_as_any_other() -> None:
    run_conformance(lambda: SlippingGrid(0.0)).raise_for_failures()
