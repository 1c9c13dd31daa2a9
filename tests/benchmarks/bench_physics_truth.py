"""Long runs: random robots, jams, queues and the books, held against what they must do.

The number of robot moves is in the environment variable ``TRUTH_MOVES``.
"""

import os
from collections import Counter
from collections.abc import Sequence

import pytest
from helpers.physics_truth import (
    differences_in_jams,
    errors_of_the_books,
    queue,
    random_robots_move_as_the_grid,
    straight_queue,
    winding_queue,
)

from warehouse_physics import stepping

MOVES = int(os.environ.get("TRUTH_MOVES", "60000"))
BOOKED = MOVES // 10
"""Moves that are booked in every substep, by slow code."""


@pytest.fixture
def public_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let each substep call ``space.step``, where the book is kept."""
    monkeypatch.setattr(stepping, "IS_KNOWN", False)


def test_random_robots_move_as_on_the_grid_alone_and_in_a_batch(measured) -> None:
    made, braked = random_robots_move_as_the_grid(MOVES)
    what = f"{made:,} moves of random robots, {braked:,} braked by the floor"
    measured(what, "0 differences to the grid and between batch and single")


def test_heavy_jams_end_as_the_table_says(measured) -> None:
    made, wrong, cut_off = differences_in_jams(MOVES)
    measured(f"{made:,} robot moves in heavy jams", f"{wrong} differences, {cut_off} cut off")
    assert (wrong, cut_off) == (0, 0)


@pytest.mark.parametrize("make_queue", [straight_queue, winding_queue])
def test_queues_of_160_end_as_the_table_says(make_queue, measured) -> None:
    layout, cells = make_queue(160)
    for loaded in (False, True):
        outcomes = queue(layout, cells, loaded)
        wrong = sum(it.cell != cell for it, cell in zip(outcomes, cells, strict=True))
        seconds = max(outcome.seconds for outcome in outcomes)
        name = f"{make_queue.__name__.replace('_', ' ')} of 160{' with loads' if loaded else ''}"
        measured(name, f"{wrong} differences, {seconds:.2f} s")
        assert wrong == 0
        assert not any(outcome.cut_off for outcome in outcomes)


@pytest.mark.usefixtures("public_steps")
@pytest.mark.parametrize("robots", [1, 8])
def test_the_books_agree_within_a_hundredth(robots: int, measured) -> None:
    errors = errors_of_the_books(BOOKED, robots, seed=1000)
    words = f"joules {_spread(errors.joules)}; impulses {_spread(errors.impulses)}"
    measured(f"against a second book, {robots} random robots at once", words)
    for each in errors:
        assert max(each, default=0.0) <= 0.01


def _spread(errors: Sequence[float]) -> str:
    above = Counter(error > 0.01 for error in errors)[True]
    worst = max(errors, default=0.0)
    return f"of {len(errors)} at most {100 * worst:.2g}% off, {above} by more than 1%"
