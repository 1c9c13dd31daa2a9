"""Ctrl-C is remembered, reaches no worker, and is the program's own again afterwards."""

import signal
import subprocess
import sys
import time
from collections.abc import Iterator

import pytest

from agents.experiments.workers import DEFERRED, blocked_interrupts, deferred_interrupts

SLEEPER = [sys.executable, "-c", "import time; print('up', flush=True); time.sleep(60)"]


@pytest.fixture(autouse=True)
def as_before() -> Iterator[None]:
    """Let SIGINT raise, which background processes may ignore; restore all handlers at the end."""
    handlers = {number: signal.getsignal(number) for number in DEFERRED}
    signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    for number, handler in handlers.items():
        signal.signal(number, handler)


def interrupt() -> None:
    """Send SIGINT to this thread; any thread of the process may get one sent by ``os.kill``."""
    signal.raise_signal(signal.SIGINT)


def test_an_interrupt_waits_until_it_is_asked_for() -> None:
    done = []
    with deferred_interrupts() as check:
        check()
        interrupt()
        interrupt()
        done.append("the step")
        with pytest.raises(KeyboardInterrupt):
            check()
    assert done == ["the step"]


def test_without_one_nothing_is_raised_and_the_handler_is_as_it_was() -> None:
    before = signal.getsignal(signal.SIGINT)
    with deferred_interrupts() as check:
        check()
    assert signal.getsignal(signal.SIGINT) is before
    with pytest.raises(KeyboardInterrupt):
        interrupt()


def test_the_end_that_a_manager_asks_for_is_remembered_too() -> None:
    with deferred_interrupts() as check:
        signal.raise_signal(signal.SIGTERM)
        with pytest.raises(KeyboardInterrupt):
            check()


def test_who_has_asked_once_cannot_disturb_the_leaving() -> None:
    with deferred_interrupts():
        interrupt()
    signal.raise_signal(signal.SIGTERM)


def test_a_child_that_is_started_so_is_not_interrupted() -> None:
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


def test_what_comes_while_children_start_comes_afterwards() -> None:
    done = []
    with deferred_interrupts() as check:
        with blocked_interrupts():
            interrupt()
            check()
            done.append("all are started")
        with pytest.raises(KeyboardInterrupt):
            check()
    assert done == ["all are started"]
