"""A sweep on a Dask cluster gives the same rows as on this machine, even if a worker is killed."""

import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.command_line import ROOT, in_a_process
from helpers.dask_cluster import MAX_WAIT, Cluster, dask_cluster, start_worker
from helpers.sweeps import AGENT, check_is_usable, table, uninterrupted, words

from agents.errors import StoreError

pytestmark = pytest.mark.cluster
EPISODES = 3000
MAIN = ["-c", "from agents.lab.commands.cli import main; main()"]


@pytest.fixture(params=["--no-nanny"])
def cluster(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Cluster]:
    """Yield a cluster with two workers."""
    with dask_cluster(tmp_path, request.param) as started:
        yield started


def start_sweep(path: Path, episodes: int, address: str) -> subprocess.Popen[str]:
    """Start a sweep and wait until there are rows."""
    sweep = subprocess.Popen(
        [sys.executable, *MAIN, *words(path, episodes), "--cluster", address],
        cwd=ROOT,
        stderr=subprocess.PIPE,
        text=True,
    )
    end = time.monotonic() + MAX_WAIT
    while not has_rows(path):
        assert sweep.poll() is None, sweep.communicate()[1]
        assert time.monotonic() < end, "no rows"
        time.sleep(0.05)
    return sweep


def has_rows(path: Path) -> bool:
    """Return whether a sweep has written rows; right after its creation a file has no tables."""
    try:
        return path.exists() and bool(table(path))
    except StoreError:
        return False


def test_a_cluster_gives_the_rows_of_this_machine_though_a_worker_is_killed(
    cluster: Cluster, tmp_path: Path
) -> None:
    address, (_, worker, _) = cluster
    path = tmp_path / "r.sqlite"
    sweep = start_sweep(path, EPISODES, address)
    assert len(table(path)) < 4 * EPISODES
    worker.kill()
    err = sweep.communicate(timeout=MAX_WAIT)[1]
    assert "Traceback" not in err
    assert sweep.returncode == 0, err
    assert table(path) == uninterrupted(tmp_path / "expected.sqlite", EPISODES)


def test_a_killed_scheduler_is_one_line_and_the_file_stays_usable(
    cluster: Cluster, tmp_path: Path
) -> None:
    address, (scheduler, *_) = cluster
    path = tmp_path / "r.sqlite"
    sweep = start_sweep(path, EPISODES * 10, address)
    scheduler.kill()
    err = sweep.communicate(timeout=MAX_WAIT)[1]
    assert sweep.returncode == 1
    assert err.splitlines()[-1].startswith(f"warehouse: the Dask cluster at {address} has failed: ")
    assert "Traceback" not in err
    check_is_usable(path)
    assert table(path)


def sweep_of(path: Path, address: str, act: str) -> subprocess.Popen[str]:
    """Start a sweep of an agent and of the greedy one; with seed 7 the agent runs this code."""
    file = path.with_suffix(".py")
    file.write_text(AGENT.format(name="Own", begin="pass", act=f"if self.seed == 7: {act}"))
    choice = ["--set", f"agent={file}:Own,greedy", "--set", "max_steps=5", "-n", "12"]
    return subprocess.Popen(
        [sys.executable, *MAIN, "sweep", *choice, "-o", str(path), "--cluster", address],
        cwd=ROOT,
        stderr=subprocess.PIPE,
        text=True,
    )


def read_until(sweep: subprocess.Popen[str], pattern: str) -> str:
    """Read the messages of a sweep until one has a pattern."""
    assert sweep.stderr is not None
    for line in sweep.stderr:
        if re.search(pattern, line):
            return line
    raise AssertionError(f"no message with {pattern}")


LAST = r"warehouse: 1 episode failed, in 1 of 2 combinations; 23 of 24 episodes in .*\n"


@pytest.mark.parametrize(
    ("cluster", "act", "place", "reason"),
    [
        ("--no-nanny", "raise KeyError", ", step 1,", r"KeyError \(r.py, line 11\)"),
        (
            "--nanny",
            "__import__('os')._exit(1)",
            "",
            "the Dask workers that ran it have ended; it was tried twice",
        ),
    ],
    indirect=["cluster"],
    ids=["fails", "ends its process"],
)
def test_an_agent_that_fails_or_ends_its_process_is_named_and_the_others_go_on(
    cluster: Cluster, tmp_path: Path, act: str, place: str, reason: str
) -> None:
    path = tmp_path / "r.sqlite"
    sweep = sweep_of(path, cluster[0], act)
    err = sweep.communicate(timeout=MAX_WAIT)[1]
    about = rf"warehouse: seed 7{place} with agent={tmp_path}/r.py:Own, max_steps=5"
    assert re.fullmatch(rf"{about}: {reason}\n{LAST}", err)
    assert sweep.returncode == 1
    check_is_usable(path)
    assert len(table(path)) == 23


def test_a_sweep_does_not_wait_for_a_worker_that_an_earlier_one_has_left_occupied(
    cluster: Cluster, tmp_path: Path
) -> None:
    address, _ = cluster
    act = "__import__('time').sleep(3600)"
    hanging = sweep_of(tmp_path / "hanging.sqlite", address, act)
    line = read_until(hanging, "has run for 10 s")
    assert line.startswith("warehouse: seed 7, step 1, with agent=")
    hanging.send_signal(signal.SIGINT)
    assert hanging.communicate(timeout=30)[1] == "warehouse: interrupted\n"
    assert hanging.returncode == 130
    path = tmp_path / "r.sqlite"
    result = in_a_process(*MAIN, *words(path, 3), "--cluster", address, folder=ROOT)
    assert result.code == 0
    assert "was occupied by a call of an ended client: re" in result.err
    assert table(path) == uninterrupted(tmp_path / "expected.sqlite", 3)


def test_that_there_are_no_workers_is_said_and_the_sweep_goes_on_with_new_ones(
    cluster: Cluster, tmp_path: Path
) -> None:
    address, processes = cluster
    path = tmp_path / "r.sqlite"
    sweep = start_sweep(path, EPISODES, address)
    killed, frozen = processes[1:]
    killed.kill()
    frozen.send_signal(signal.SIGSTOP)
    line = read_until(sweep, "no workers for 10 s")
    assert f"'dask worker {address}'" in line
    frozen.kill()
    processes.append(start_worker(tmp_path, 2, address))
    assert sweep.communicate(timeout=MAX_WAIT)[1] == ""
    assert sweep.returncode == 0
    assert table(path) == uninterrupted(tmp_path / "expected.sqlite", EPISODES)


def test_no_scheduler_is_one_line_and_exit_code_1(tmp_path: Path) -> None:
    address = "tcp://127.0.0.1:9"
    here = [*words(tmp_path / "r.sqlite", 3), "--cluster", address]
    result = in_a_process(*MAIN, *here, folder=ROOT)
    assert result.code == 1
    assert result.err.count("\n") == 1
    assert result.err.startswith(f"warehouse: no Dask scheduler answers at {address}")
