"""Helpers for tests of sweeps: their command, their rows, and an executor without workers."""

from collections.abc import Callable, Sequence
from concurrent.futures import Executor, Future
from pathlib import Path
from typing import Any

from agents.experiments.choices import parse_flags
from agents.experiments.plan import make_plan
from agents.experiments.running import run_missing
from agents.experiments.store import Row, Store

TABLE = "SELECT settings, episodes.* FROM episodes JOIN cases ON id = case_id ORDER BY 1, 3"


class Here(Executor):
    """Runs everything in this process, and records the seeds of each task."""

    def __init__(self, fails_at: int | None = None) -> None:
        self.seeds: list[int] = []
        self.fails_at = fails_at

    def submit(self, call: Callable[..., Any], /, *args: Any, **named: Any) -> Future[Any]:
        future: Future[Any] = Future()
        self.seeds += args[1]
        if self.fails_at is not None and self.fails_at in args[1]:
            future.set_exception(ArithmeticError("a worker failed"))
        else:
            future.set_result(call(*args, **named))
        return future


def nothing(rows: Sequence[Row], failures: Sequence[str] = ()) -> None:
    pass


def table(path: Path) -> list[tuple[Any, ...]]:
    with Store(path, read_only=True) as store:
        return [(found[0], *found[2:]) for found in store.query(TABLE)]


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
    sizes = ["-n", str(episodes), "--workers", str(workers), "--seed", "3"]
    return ["sweep", *choices, *sizes, "-o", str(output)]


def uninterrupted(path: Path, episodes: int) -> list[Any]:
    with Store(path) as store:
        run_missing(make_plan(parse_flags(FLAGS), episodes, 3), store, Here(), 1, nothing)
    return table(path)


def check_is_usable(path: Path) -> None:
    with Store(path, read_only=True) as store:
        assert list(store.query("PRAGMA integrity_check")) == [("ok",)]
