from helpers.command_line import Warehouse

from agents.lab.commands.compare_backends import comparison_table, first_difference
from agents.run_episode import run_episode
from warehouse_core import replay_episode


def test_the_first_step_that_differs_is_found() -> None:
    grid, physics = (run_episode(backend=backend, seed=12) for backend in ("grid", "physics"))
    other, shorter = replay_episode(grid), run_episode(seed=12, max_steps=10)
    other.actions[3] = "WAIT"
    assert first_difference(grid, grid) is first_difference(grid, physics) is None
    assert first_difference(grid, replay_episode(other)) == 4
    assert first_difference(grid, shorter) == first_difference(shorter, grid) == 11
    header, rows, *_ = comparison_table({"grid": grid, "physics": physics, "short": shorter})
    assert header == ("", "grid", "physics", "short")
    assert rows[0] == ("outcome", "delivered", "delivered", "out of time")
    assert rows[3] == ("seconds", "-", "49.8", "-")
    assert rows[-1] == ("first step that differs", "-", "none", "step 11")


def test_a_single_backend_is_compared_with_the_grid(warehouse: Warehouse) -> None:
    words = ("compare", "backends", "--no-show", "--seed", 3, "--max-steps", 9)
    out = warehouse(*words, "--backend", "physics:motor_strength=0.2").out
    assert "driving" not in out
    assert "Both visit different cells." in out
    assert "names grid twice" in warehouse(*words, "--backend", "grid").err


def test_slippery_cells_are_for_the_backends_with_bodies(warehouse: Warehouse) -> None:
    words = ("compare", "backends", "--slippery", "1,2", "--seed", 12, "--save", "both.png")
    out = warehouse(*words, "--max-steps", 2).out
    assert "physics:slippery=1-2" in out
    assert "grid:" not in out
