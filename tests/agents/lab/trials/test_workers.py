"""Workers end with their parent, an ended worker fails only its call, and interrupts wait."""

import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from concurrent.futures import Executor
from functools import partial
from pathlib import Path

import pytest
from helpers.command_line import ROOT

from agents.errors import WorkerError
from agents.lab.trials.workers import Processes, blocked_interrupts, deferred_interrupts

ORPHAN_MAKER = """
import os, time
from agents.lab.trials.workers import Processes
if __name__ == "__main__":
    with Processes(2) as executor:
        print(executor.submit(os.getpid).result(), flush=True)
        time.sleep(60)
"""


def pid() -> int:
    time.sleep(0.05)
    return os.getpid()


def pids(executor: Executor) -> set[int]:
    futures = [executor.submit(pid) for _ in range(2)]
    return {future.result() for future in futures}


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
    with pytest.raises(ArithmeticError), Processes(2) as executor:  # noqa: PT012
        found = pids(executor)
        assert len(found) == 2
        assert found == {each.pid for each in multiprocessing.active_children()}
        for number in found:
            os.kill(number, signal.SIGINT)
        assert pids(executor) == found
        waiting = [executor.submit(time.sleep, 60) for _ in range(5)]
        raise ArithmeticError
    assert not any(map(is_running, found))
    assert all(future.done() for future in waiting)


ENDINGS: dict[str, Callable[[], None]] = {
    "its process ended with exit code 3": partial(os._exit, 3),
    "its process was ended by signal 6 (Aborted)": os.abort,
}


def test_a_worker_that_ends_fails_only_its_own_call() -> None:
    with Processes(2) as executor:
        for reason, end in ENDINGS.items():
            before = pids(executor)
            other, ending = executor.submit(pid), executor.submit(end)
            with pytest.raises(WorkerError) as caught:
                ending.result()
            assert str(caught.value) == reason
            assert other.result() in before
            after = pids(executor)
            assert (len(after), len(after & before)) == (2, 1)


def leave_a_thread() -> int:
    threading.Thread(target=time.sleep, args=(60,)).start()
    return os.getpid()


def test_a_worker_survives_an_exception_and_ends_in_spite_of_threads() -> None:
    with Processes(1) as executor:
        before = executor.submit(os.getpid).result()
        with pytest.raises(ZeroDivisionError):
            executor.submit(divmod, 1, 0).result()
        assert executor.submit(leave_a_thread).result() == before
    assert not is_running(before)


def hold(folder: str) -> None:
    """Sleep for a minute, catch an interrupt as agents may, and remove a folder at the end."""
    try:
        os.mkdir(folder)
        time.sleep(60)
    except KeyboardInterrupt:
        return
    finally:
        os.rmdir(folder)


@pytest.mark.parametrize("seconds", [None, 4.0])
def test_a_call_that_is_ended_removes_what_it_has_made(tmp_path: Path, seconds: float) -> None:
    """It is ended by the end of the block, or by the limit on its time."""
    folder = tmp_path / "made"
    with Processes(1, seconds) as executor:
        ended = executor.submit(hold, str(folder))
        if seconds is None:
            while not folder.exists():
                time.sleep(0.01)
        else:
            with pytest.raises(WorkerError, match="its process was ended after 4 s"):
                ended.result()
    assert isinstance(ended.exception(), WorkerError)
    assert not folder.exists()


def test_workers_end_when_their_parent_is_killed() -> None:
    with subprocess.Popen(
        [sys.executable, "-c", ORPHAN_MAKER], cwd=ROOT, stdout=subprocess.PIPE, text=True
    ) as parent:
        assert parent.stdout is not None
        found = {int(word) for word in parent.stdout.readline().split()}
        assert found
        parent.kill()
    wait_until_gone(found)


SLEEPER = [sys.executable, "-c", "import time; print('up', flush=True); time.sleep(60)"]


def interrupt() -> None:
    """Send SIGINT to this thread; ``os.kill`` could reach any thread of the process."""
    signal.raise_signal(signal.SIGINT)


@pytest.mark.usefixtures("interrupts_raise")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_is_deferred_until_the_check(number: int) -> None:
    done = []
    with deferred_interrupts() as check:
        check()
        signal.raise_signal(number)
        signal.raise_signal(number)
        done.append("step done")
        with pytest.raises(KeyboardInterrupt):
            check()
    assert done == ["step done"]


@pytest.mark.usefixtures("interrupts_raise")
def test_after_a_deferred_interrupt_further_signals_are_ignored() -> None:
    with deferred_interrupts():
        interrupt()
    signal.raise_signal(signal.SIGTERM)


@pytest.mark.usefixtures("interrupts_raise")
def test_a_child_started_with_blocked_interrupts_is_not_interrupted() -> None:
    with blocked_interrupts():
        child = subprocess.Popen(SLEEPER, stdout=subprocess.PIPE)
    try:
        assert child.stdout is not None
        child.stdout.readline()
        child.send_signal(signal.SIGINT)
        time.sleep(0.2)
        assert child.poll() is None
    finally:
        child.kill()
        child.communicate()
