"""A sweep on a Dask cluster gives the same rows as on this machine, even if a worker is killed."""

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.command_line import ROOT, in_a_process, refusal
from helpers.sweeps import AGENT, check_is_usable, table, uninterrupted, words

pytestmark = pytest.mark.cluster
EPISODES = 3000
MAIN = ["-c", "from agents.cli import main; main()"]


def start(log: Path, *arguments: str) -> subprocess.Popen[bytes]:
    with log.open("wb") as file:
        return subprocess.Popen(
            [sys.executable, "-m", *arguments],
            cwd=ROOT,
            stdout=file,
            stderr=file,
            start_new_session=True,
        )


def wait_for(log: Path, pattern: str) -> str:
    end = time.monotonic() + 60
    while not (found := re.search(pattern, log.read_text())):
        assert time.monotonic() < end, log.read_text()
        time.sleep(0.05)
    return found[0]


Cluster = tuple[str, list[subprocess.Popen[bytes]]]
"""The address of a scheduler, its process, and those of its workers."""


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[Cluster]:
    """Yield the address of a scheduler on this machine, and its two workers."""
    log = tmp_path / "scheduler.log"
    own = ("--host", "127.0.0.1", "--no-dashboard")
    processes = [start(log, "distributed.cli.dask_scheduler", *own, "--port", "0")]
    try:
        address = wait_for(log, r"tcp://127\.0\.0\.1:\d+")
        for number in range(2):
            log = tmp_path / f"worker{number}.log"
            own = ("--no-nanny", "--nthreads", "1", "--no-dashboard", "--host", "127.0.0.1")
            folder = ("--local-directory", str(tmp_path / f"w{number}"))
            processes.append(start(log, "distributed.cli.dask_worker", address, *own, *folder))
        for number in range(2):
            wait_for(tmp_path / f"worker{number}.log", "Registered to")
        yield address, processes
    finally:
        for process in processes:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()


def start_sweep(path: Path, episodes: int, address: str) -> subprocess.Popen[str]:
    """Start a sweep and wait until there are rows."""
    sweep = subprocess.Popen(
        [sys.executable, *MAIN, *words(path, episodes), "--cluster", address],
        cwd=ROOT,
        stderr=subprocess.PIPE,
        text=True,
    )
    end = time.monotonic() + 60
    while not path.exists() or not table(path):
        assert time.monotonic() < end
        time.sleep(0.05)
    return sweep


@pytest.mark.parametrize("killed", [0, 1])
def test_a_cluster_gives_the_rows_of_this_machine(
    cluster: Cluster, tmp_path: Path, killed: int
) -> None:
    address, (_, *workers) = cluster
    path = tmp_path / "r.sqlite"
    sweep = start_sweep(path, EPISODES, address)
    for worker in workers[:killed]:
        worker.kill()
    assert sweep.poll() is None
    err = sweep.communicate(timeout=120)[1]
    assert "Traceback" not in err
    assert sweep.returncode == 0
    assert table(path) == uninterrupted(tmp_path / "expected.sqlite", EPISODES)


def test_a_killed_scheduler_is_one_line_and_the_file_stays_usable(
    cluster: Cluster, tmp_path: Path
) -> None:
    address, (scheduler, *_) = cluster
    path = tmp_path / "r.sqlite"
    sweep = start_sweep(path, EPISODES * 10, address)
    scheduler.kill()
    err = sweep.communicate(timeout=120)[1]
    assert sweep.returncode == 1
    assert err.splitlines()[-1].startswith(f"warehouse: the Dask cluster at {address} has failed: ")
    assert "Traceback" not in err
    check_is_usable(path)
    assert table(path)


def test_an_agent_that_fails_on_a_cluster_is_one_line(cluster: Cluster, tmp_path: Path) -> None:
    file, path = tmp_path / "agent.py", tmp_path / "r.sqlite"
    file.write_text(AGENT.format(name="Own", begin="pass", act="if self.seed == 7: raise KeyError"))
    choice = ["--set", f"agent={file}:Own", "-n", "20", "-o", str(path), "--cluster", cluster[0]]
    result = in_a_process(*MAIN, "sweep", *choice, folder=ROOT)
    assert result.code == 1
    assert result.err == f"warehouse: seed 7 with agent={file}:Own: KeyError (agent.py, line 11)\n"
    check_is_usable(path)


def test_no_scheduler_is_one_line_and_exit_code_1(tmp_path: Path) -> None:
    here = [*words(tmp_path / "r.sqlite", 3), "--cluster", "tcp://127.0.0.1:9"]
    result = in_a_process(*MAIN, *here, folder=ROOT)
    assert result.code == 1
    assert result.err.count("\n") == 1
    assert result.err.startswith("warehouse: no Dask scheduler answers at tcp://127.0.0.1:9")


def test_no_address_is_one_line(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    line = refusal(capsys, *words(tmp_path / "r.sqlite", 3), "--cluster", "nowhere:x:y")
    assert "nowhere" in line
