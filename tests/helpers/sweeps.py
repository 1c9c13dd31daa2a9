"""Helpers for tests of sweeps: the command, the rows, and an executor without workers."""

import random
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Sequence
from concurrent.futures import Executor, Future
from contextlib import suppress
from pathlib import Path
from typing import Any, ClassVar

from agents.errors import StoreError
from agents.lab.experiments.plan import SweepPlan, make_plan, parse_flags
from agents.lab.experiments.store import COLUMNS, Store
from agents.lab.experiments.sweep import SweepRun
from helpers import executors
from helpers.command_line import ROOT

ROWS = (
    f"SELECT settings, {', '.join(COLUMNS)} FROM episodes JOIN cases ON id = case_id "
    "ORDER BY settings, seed"
)
"""Query for all rows."""


class Here(executors.Here):
    """Runs everything in this process, and records the seeds of each task."""

    def __init__(self) -> None:
        self.seeds: list[int] = []

    def submit(self, call: Callable[..., Any], /, *args: Any, **named: Any) -> Future[Any]:
        self.seeds += args[1]
        return super().submit(call, *args, **named)


def run_missing(
    plan: SweepPlan,
    store: Store,
    executor: Executor,
    workers: int = 1,
    report: Callable[[Sequence[Any], str], None] = lambda rows, failure: None,
) -> Counter[int]:
    """Run the missing episodes of a plan, and return the number of failures by case number."""
    run = SweepRun(plan, store)
    for rows, failure in run.episodes(executor, workers):
        report(rows, failure)
    return run.failed


def table(path: Path) -> list[tuple[Any, ...]]:
    with Store(path, read_only=True) as store:
        return list(store.query(ROWS))


AGENT = """
class {name}:
    def __init__(self, seed):
        {begin}
        self.seed = seed

    def reset(self):
        pass

    def act(self, observation):
        {act}
        return "N"
"""


FLAGS = ["escape=on,off", "battery=20,60"]


def words(output: Path, episodes: int, flags: Sequence[str] = FLAGS, workers: int = 2) -> list[str]:
    choices = [word for flag in flags for word in ("--set", flag)]
    sizes = ["-n", str(episodes), "--jobs", str(workers), "--seed", "3"]
    return ["sweep", *choices, *sizes, "-o", str(output)]


def uninterrupted(path: Path, episodes: int, flags: Sequence[str] = FLAGS) -> list[Any]:
    with Store(path) as store:
        run_missing(make_plan(parse_flags(flags), episodes, 3), store, Here())
    return table(path)


def check_is_usable(path: Path) -> None:
    with Store(path, read_only=True) as store:
        assert list(store.query("PRAGMA integrity_check")) == [("ok",)]


class Sweep:
    """A sweep in its own session."""

    started: ClassVar[list["Sweep"]] = []

    def __init__(
        self,
        output: Path,
        episodes: int,
        flags: Sequence[str] = FLAGS,
        *options: str,
        workers: int = 2,
        python: str = sys.executable,
    ) -> None:
        self.started.append(self)
        self.output = output
        command = words(output, episodes, flags, workers)
        self.process = subprocess.Popen(
            [python, "-c", "from agents.lab.commands.cli import main; main()", *command, *options],
            cwd=ROOT,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )

    def wait_for_rows(self) -> None:
        """Wait until more rows have been stored."""
        before, end = self._rows(), time.monotonic() + 60
        while self._rows() == before and self.process.poll() is None:
            assert time.monotonic() < end
            time.sleep(0.02)

    def end(self, seconds: float = 60) -> tuple[int, str, str]:
        """Wait until the sweep and all processes that it started have ended."""
        out, err = self.process.communicate(timeout=seconds)
        end = time.monotonic() + 10
        while alive := in_session(self.process.pid):
            assert time.monotonic() < end, f"{alive} are left"
            time.sleep(0.02)
        return self.process.returncode, out, err

    def _rows(self) -> int:
        with suppress(StoreError), Store(self.output, read_only=True) as store:
            count: int = next(store.query("SELECT count(*) FROM episodes"))[0]
            return count
        return 0


def in_session(session: int) -> list[str]:
    """Return the running processes of a session."""
    found = subprocess.run(
        ["ps", "-s", str(session), "-o", "pid=,stat=,args="],
        capture_output=True,
        text=True,
        check=False,
    )
    lines = found.stdout.splitlines()
    return [line for line in lines if not line.split()[1].startswith("Z")]


def kill_sweeps(
    path: Path,
    episodes: int,
    kills: int,
    flags: Sequence[str] = FLAGS,
    python: str = sys.executable,
) -> int:
    """Start sweeps and kill each; return how many were running.

    Raises:
        AssertionError: the file is damaged, or rows are lost or changed.
    """
    # With this seed, the first sweep is killed soon after its first rows.
    moments, killed, before = random.Random(42), 0, set[Any]()
    for _ in range(kills):
        sweep = Sweep(path, episodes, flags, python=python)
        if moments.random() < 0.75:
            sweep.wait_for_rows()
            time.sleep(moments.uniform(0, 0.3))
        else:
            time.sleep(moments.uniform(0, 1.2))
        sweep.process.kill()
        killed += sweep.end()[0] == -signal.SIGKILL
        if path.exists():
            check_is_usable(path)
            now = set(table(path))
            assert before <= now
            before = now
    return killed
