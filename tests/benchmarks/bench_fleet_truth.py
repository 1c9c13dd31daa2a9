"""Long runs: a fleet of one against the chapter's warehouse, and bodies against the grid.

``TRUTH_SHARE=0.1`` takes a tenth of all steps.
"""

import os
from collections import Counter

import pytest
from helpers.fleet_truth import bodies_move_as_the_grid, random_lone_steps_equal

SHARE = float(os.environ.get("TRUTH_SHARE", "1"))
STEPS = round(250_000 * SHARE)
JOINT_ACTIONS = {2: 8000, 5: 5000, 12: 4000, 30: 2000, 100: 1000}

pytestmark = pytest.mark.filterwarnings("ignore:.*can keep")


@pytest.mark.parametrize("backend", ["grid", "physics"])
def test_a_fleet_of_one_equals_the_warehouse(backend: str, measured) -> None:
    episodes = random_lone_steps_equal(STEPS, seed=7, backend=backend)
    measured(
        f"a fleet of one against WarehouseEnv, {backend}",
        f"{STEPS:,} random steps in {episodes:,} episodes, 0 differences",
    )


def test_nominal_bodies_equal_the_grid(measured) -> None:
    stops, moves = Counter[str](), 0
    for robots, joint_actions in JOINT_ACTIONS.items():
        stops += bodies_move_as_the_grid(robots, round(joint_actions * SHARE), seed=robots)
        moves += round(joint_actions * SHARE)
    words = ", ".join(f"{count:,} {what}" for what, count in stops.most_common())
    measured(
        f"fleets of bodies against the grid, {moves:,} joint actions of 2 to 100 robots",
        f"0 differences; {words}",
    )
