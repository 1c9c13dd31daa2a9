"""Worker processes end with their parent, and a killed worker is an error."""

import multiprocessing
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import Executor

import pytest
from helpers.command_line import ROOT

from agents.errors import WorkerError
from agents.experiments import workers
from agents.experiments.workers import KILLED, process_pool

ORPHAN_MAKER = """
import os, time
from agents.experiments.workers import process_pool
if __name__ == "__main__":
    with process_pool(2) as (executor, count):
        print(*{executor.submit(os.getpid).result() for _ in range(50)}, flush=True)
        time.sleep(60)
"""


def pids(executor: Executor) -> set[int]:
    return {executor.submit(os.getpid).result() for _ in range(50)}


def wait_until_gone(numbers: set[int]) -> None:
    end = time.monotonic() + 20
    while any(is_running(number) for number in numbers):
        assert time.monotonic() < end
        time.sleep(0.02)


def is_running(number: int) -> bool:
    try:
        with open(f"/proc/{number}/stat") as file:
            return file.read().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def test_workers_are_other_processes_that_ignore_interrupts_and_end_with_the_block() -> None:
    with process_pool(2) as (executor, count):
        assert count == 2
        found = pids(executor)
        assert 1 <= len(found) <= 2
        assert os.getpid() not in found
        assert len(multiprocessing.active_children()) == 2
        for process in multiprocessing.active_children():
            assert process.pid is not None
            os.kill(process.pid, signal.SIGINT)
        assert pids(executor) <= {each.pid for each in multiprocessing.active_children()}
        assert len(multiprocessing.active_children()) == 2
    wait_until_gone(found)


def test_an_error_in_the_block_kills_the_workers() -> None:
    with pytest.raises(ArithmeticError), process_pool(1) as (executor, _):  # noqa: PT012
        found = pids(executor)
        executor.submit(time.sleep, 60)
        raise ArithmeticError
    wait_until_gone(found)


def test_a_killed_worker_is_an_error() -> None:
    with pytest.raises(WorkerError) as caught, process_pool(2) as (executor, _):  # noqa: PT012
        [*found] = pids(executor)
        sleep = executor.submit(time.sleep, 60)
        os.kill(found[0], signal.SIGKILL)
        sleep.result()
    assert str(caught.value) == KILLED
    wait_until_gone(set(found))


def test_workers_end_when_their_parent_is_killed() -> None:
    with subprocess.Popen(
        [sys.executable, "-c", ORPHAN_MAKER], cwd=ROOT, stdout=subprocess.PIPE, text=True
    ) as parent:
        assert parent.stdout is not None
        found = {int(word) for word in parent.stdout.readline().split()}
        assert found
        parent.kill()
    wait_until_gone(found)


def test_the_number_of_workers_is_at_most_max_processes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(workers, "MAX_PROCESSES", 1)
    with process_pool(2) as (_, count):
        assert count == 1
