"""Processes that run episodes: they end with whoever started them, and one that dies is told of."""

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


def test_work_is_done_by_other_processes_that_end_with_the_block() -> None:
    with process_pool(2) as (executor, count):
        assert count == 2
        found = pids(executor)
        assert 1 <= len(found) <= 2
        assert os.getpid() not in found
        assert len(multiprocessing.active_children()) == 2
    wait_until_gone(found)


def test_an_error_ends_them_at_once() -> None:
    with pytest.raises(ArithmeticError), process_pool(1) as (executor, _):  # noqa: PT012
        found = pids(executor)
        executor.submit(time.sleep, 60)
        raise ArithmeticError
    wait_until_gone(found)


@pytest.mark.parametrize("is_busy", [False, True])
def test_a_process_that_is_killed_is_one_line(is_busy: bool) -> None:
    with pytest.raises(WorkerError) as caught, process_pool(2) as (executor, _):  # noqa: PT012
        [*found] = pids(executor)
        sleeps = [executor.submit(time.sleep, 60) for _ in range(2 if is_busy else 0)]
        os.kill(found[0], signal.SIGKILL)
        for each in sleeps:
            each.result()
        while True:
            executor.submit(os.getpid).result()
    assert str(caught.value) == KILLED
    wait_until_gone(set(found))


def test_they_ignore_interrupts() -> None:
    with process_pool(1) as (executor, _):
        [found] = pids(executor)
        os.kill(found, signal.SIGINT)
        assert pids(executor) == {found}


def test_they_end_with_the_process_that_started_them_however_it_ends() -> None:
    with subprocess.Popen(
        [sys.executable, "-c", ORPHAN_MAKER], cwd=ROOT, stdout=subprocess.PIPE, text=True
    ) as parent:
        assert parent.stdout is not None
        found = {int(word) for word in parent.stdout.readline().split()}
        assert found
        parent.kill()
    wait_until_gone(found)


def test_there_are_no_more_than_can_be_waited_for(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(workers, "MAX_PROCESSES", 1)
    with process_pool(2) as (_, count):
        assert count == 1
