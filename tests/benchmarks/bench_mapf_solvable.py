"""Problems without a plan: how many are proved to be so, and how many a search decides."""

import time

import numpy as np
from helpers.mapf_problems import random_problems

from agents.errors import PlanError
from agents.mapf.lacam import lacam
from agents.mapf.solvable import check_solvable

SECONDS = 2.0


def test_proofs_that_there_is_no_plan(measured) -> None:
    """Small floors with up to 8 robots; a plan of LaCAM says that there is one."""
    counts, times = dict.fromkeys(("plan", "none", "timeout"), 0), list[float]()
    proved = dict.fromkeys(counts, 0)
    for problem in random_problems(1000, seed=3, max_size=4):
        start = time.process_time()
        try:
            check_solvable(problem)
            is_proved = False
        except PlanError:
            is_proved = True
        times.append(time.process_time() - start)
        try:
            lacam(problem, SECONDS)
            end = "plan"
        except PlanError as error:
            end = "none" if str(error).startswith("there is no plan") else "timeout"
        counts[end] += 1
        proved[end] += is_proved
    measured(
        "problems of up to 8 robots on floors of up to 4 x 4 cells without a plan",
        f"of {counts['none']} that LaCAM decides {proved['none']} are proved to have none; of "
        f"{counts['timeout']} that it does not decide in {SECONDS:g} s {proved['timeout']}; of "
        f"{counts['plan']} with a plan {proved['plan']}; a proof takes {1000 * np.mean(times):.1f} "
        f"ms, at most {1000 * max(times):.0f} ms",
    )
    assert proved["plan"] == 0
