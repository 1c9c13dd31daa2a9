"""Plans of the solver ``anytime`` for MovingAI's scenarios, beside what others need.

The environment variable ``MOVINGAI_DATA`` names a folder with a folder for each map, as they are
unpacked from movingai.com/benchmarks/mapf: the map and its scenarios. The first random scenario is
taken.
"""

import os
import time
from pathlib import Path

import pytest
from helpers.mapf_validator import plan_conflict

from agents.lab.commands.planners.floors import scenario_problem
from agents.mapf.anytime import solve_anytime
from agents.mapf.kernels.buffers import IS_COMPILED

MOST = {
    ("random-32-32-20", 409, 30): 1.8,
    ("maze-32-32-4", 300, 30): 2.8,
    ("warehouse-10-20-10-2-1", 1_000, 30): 2.0,
    ("den312d", 1_000, 30): 4.5,
    ("Paris_1_256", 1_000, 30): 1.02,
    ("random-32-32-20", 100, 10): 1.12,
    ("random-32-32-20", 200, 10): 1.30,
    ("random-32-32-20", 300, 10): 1.66,
    ("random-32-32-20", 400, 10): 2.27,
    ("warehouse-10-20-10-2-1", 100, 10): 1.02,
    ("warehouse-10-20-10-2-1", 200, 10): 1.05,
    ("warehouse-10-20-10-2-1", 400, 10): 1.13,
}
"""Sum of costs over its lower bound, at most, by map, robots and seconds.

Those of random-32-32-20 in 10 s are LaCAM3's, built and run on this kind of machine.
"""

pytestmark = pytest.mark.usefixtures("processor_clock")


@pytest.mark.parametrize("place", MOST, ids=str)
def test_scenarios(place: tuple[str, int, int], measured) -> None:
    name, robots, seconds = place
    file = Path(os.environ["MOVINGAI_DATA"], name, f"{name}-random-1.scen")
    problem = scenario_problem(file, str(file.with_name(f"{name}.map")), robots)
    start = time.process_time()
    plan = solve_anytime(problem, seconds)
    took = time.process_time() - start
    rows = problem.graph.layout.rows
    assert plan_conflict(rows, problem.starts, problem.goals, plan.cells.tolist()) is None
    ratio = plan.sum_of_costs / problem.lower_bound
    form = "compiled" if IS_COMPILED else "plain"
    measured(
        f"{name}, {robots} robots, {seconds} s, costs over the lower bound ({form})",
        f"{ratio:.3f}; {took:.1f} s of CPU time with all distances",
    )
    assert ratio <= MOST[place]
