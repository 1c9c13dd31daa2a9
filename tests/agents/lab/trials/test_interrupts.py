"""SIGINT and SIGTERM are deferred, and SIGINT does not reach workers."""

import signal
import subprocess
import sys
import time

import pytest

from agents.lab.trials.workers import blocked_interrupts, deferred_interrupts

pytestmark = pytest.mark.usefixtures("interrupts_raise")
SLEEPER = [sys.executable, "-c", "import time; print('up', flush=True); time.sleep(60)"]


def interrupt() -> None:
    """Send SIGINT to this thread; ``os.kill`` could reach any thread of the process."""
    signal.raise_signal(signal.SIGINT)


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


def test_without_an_interrupt_nothing_is_raised_and_the_handler_is_restored() -> None:
    before = signal.getsignal(signal.SIGINT)
    with deferred_interrupts() as check:
        check()
    assert signal.getsignal(signal.SIGINT) is before
    with pytest.raises(KeyboardInterrupt):
        interrupt()


def test_after_a_deferred_interrupt_further_signals_are_ignored() -> None:
    with deferred_interrupts():
        interrupt()
    signal.raise_signal(signal.SIGTERM)


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


def test_an_interrupt_while_children_start_is_raised_afterwards() -> None:
    done = []
    with deferred_interrupts() as check:
        with blocked_interrupts():
            interrupt()
            check()
            done.append("all have started")
        with pytest.raises(KeyboardInterrupt):
            check()
    assert done == ["all have started"]
