"""Grading: an episode has a process of its own, which must cost less than a start of Python."""

import subprocess
import sys
from time import perf_counter

from helpers.submissions import GOOD, write_rubric
from helpers.timing import processor_seconds

from agents.lab.grading.grading import grade
from agents.lab.grading.rubric import MINI_LAB, load_rubric
from agents.lab.grading.runs import run_case
from agents.lab.grading.sandbox import Sandbox
from agents.lab.grading.submissions import find_submission


def test_an_episode_in_its_own_process_is_faster_than_a_start_of_python(
    tmp_path, times_faster
) -> None:
    file = tmp_path / "agent.py"
    file.write_text(f"import numpy\n{GOOD}", encoding="utf-8")
    rubric = load_rubric(write_rubric(tmp_path))
    submission, case = find_submission(str(file)), rubric.cases["chapter"]
    with Sandbox(submission, rubric.limits) as sandbox:

        def ours() -> None:
            assert run_case(sandbox, submission, case, 1).delivered

        def start() -> None:
            subprocess.run([sys.executable, "-c", "import numpy"], check=True)

        assert times_faster(ours, start) > 2


def test_submissions_a_minute(tmp_path, measured) -> None:
    """Of one process, with the rubric of the mini-lab, from its first episode to its report."""
    file = tmp_path / "agent.py"
    file.write_text(GOOD, encoding="utf-8")
    submission, rubric = find_submission(str(file)), load_rubric(MINI_LAB)
    begin, used = perf_counter(), processor_seconds()
    report = grade(submission, rubric)
    taken, used = perf_counter() - begin, processor_seconds() - used
    episode = (
        f"{taken / report.episodes * 1000:.1f} ms, {used / report.episodes * 1000:.1f} of a core"
    )
    measured("graded agents, an episode", episode)
    measured("graded agents, submissions a minute in one process", f"{60 / taken:.0f}")
