"""A Dask cluster on this machine, for tests of sweeps."""

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from helpers.command_line import ROOT

MAX_WAIT = 300
"""Seconds; a machine that has just installed the libraries reads them slowly."""

Cluster = tuple[str, list[subprocess.Popen[bytes]]]
"""The address of a scheduler, its process, and those of its workers."""


def start(python: str, log: Path, *arguments: str) -> subprocess.Popen[bytes]:
    with log.open("wb") as file:
        return subprocess.Popen(
            [python, "-m", *arguments],
            cwd=ROOT,
            stdout=file,
            stderr=file,
            start_new_session=True,
        )


def wait_for(log: Path, pattern: str) -> str:
    end = time.monotonic() + MAX_WAIT
    while not (found := re.search(pattern, log.read_text())):
        assert time.monotonic() < end, log.read_text()
        time.sleep(0.05)
    return found[0]


def start_worker(
    folder: Path, number: int, address: str, *options: str, python: str = sys.executable
) -> subprocess.Popen[bytes]:
    """Start a worker with one thread, and wait until the scheduler knows it."""
    log = folder / f"worker{number}.log"
    own = ("--nthreads", "1", "--no-dashboard", "--host", "127.0.0.1")
    data = ("--local-directory", str(folder / f"w{number}"))
    worker = start(python, log, "distributed.cli.dask_worker", address, *own, *data, *options)
    wait_for(log, "Registered to")
    return worker


@contextmanager
def dask_cluster(folder: Path, *options: str, python: str = sys.executable) -> Iterator[Cluster]:
    """Yield a cluster with two workers, which have these options."""
    log = folder / "scheduler.log"
    own = ("--host", "127.0.0.1", "--no-dashboard")
    processes = [start(python, log, "distributed.cli.dask_scheduler", *own, "--port", "0")]
    try:
        address = wait_for(log, r"tcp://127\.0\.0\.1:\d+")
        for number in range(2):
            processes.append(start_worker(folder, number, address, *options, python=python))
        yield address, processes
    finally:
        for process in processes:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
