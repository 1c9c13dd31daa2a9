"""Fixtures that several test files share, such as a recorded episode and a limit on memory."""

import random
import signal
import tracemalloc
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from functools import partial
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest
from helpers.command_line import Refused, Warehouse, command, refusal
from helpers.forms import use_loops
from hypothesis import settings

from warehouse_core import Episode, WarehouseEnv, record_episode

settings.register_profile("warehouse", deadline=None, database=None, derandomize=True)
settings.load_profile("warehouse")

MAX_MEMORY = 64 * 1024 * 1024


@pytest.fixture(params=["arrays", "loops"])
def form(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """Run a test with both forms of fleets; see ``use_loops``."""
    use_loops(monkeypatch, request.param == "loops")
    return str(request.param)


class ClumsyAgent:
    """Takes random actions, words, indices and invalid ones, with reasons in two languages."""

    ACTIONS = ("N", "e", "S", "w", "WAIT", "PICK", "DROP", 0, 1, 2, 3, 99, "fly")

    def __init__(self, seed: int) -> None:
        self.seed = seed
        self.reset()

    def reset(self) -> None:
        self.stream = random.Random(self.seed)
        self.reason = ""

    def act(self, observation: object) -> str | int:
        self.reason = self.stream.choice(("", "because", "müde"))
        return self.stream.choice(self.ACTIONS)


@pytest.fixture
def clumsy_agent() -> ClumsyAgent:
    return ClumsyAgent(seed=1)


@pytest.fixture(scope="session")
def episode() -> Episode:
    """Return an episode with moves, bumps, words, indices and invalid actions."""
    return record_episode(WarehouseEnv(max_steps=60), ClumsyAgent(seed=1), seed=3)


@pytest.fixture
def saved(episode: Episode, tmp_path: Path) -> Path:
    """Return the file of that episode."""
    path = tmp_path / "episode.npz"
    episode.save(path)
    return path


@pytest.fixture
def warehouse(capsys: pytest.CaptureFixture[str]) -> Warehouse:
    """Return a function that runs a command of ``warehouse`` in this process."""
    return partial(command, capsys)


@pytest.fixture
def refused(capsys: pytest.CaptureFixture[str]) -> Refused:
    """Return a function that runs a command that must fail, and returns its single line."""
    return partial(refusal, capsys)


@pytest.fixture
def small_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Draw small pictures without texts, which take most of the time."""
    from matplotlib.backends.backend_agg import RendererAgg

    from warehouse_core.viz import figure

    for make in (figure.make_figure, figure.make_window):
        monkeypatch.setattr(make, "__defaults__", (20,))
    monkeypatch.setattr(RendererAgg, "draw_text", lambda *_, **__: None)


@pytest.fixture
def install(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., None]]:
    """Return a function that replaces the entry points of all installed backends."""
    from warehouse_core.motion import backends

    def forget() -> None:
        backends._entry_points.cache_clear()
        backends.load_backend.cache_clear()

    def install(*points: EntryPoint) -> None:
        monkeypatch.setattr("importlib.metadata.entry_points", lambda group: list(points))
        forget()

    forget()
    yield install
    monkeypatch.undo()
    forget()


@pytest.fixture
def little_memory() -> Callable[[], AbstractContextManager[None]]:
    """Return a context manager that allows its block 64 MiB of additional memory."""

    @contextmanager
    def watch() -> Iterator[None]:
        tracemalloc.start()
        try:
            yield
            peak = tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()
        assert peak < MAX_MEMORY

    return watch


@pytest.fixture
def interrupts_raise() -> Iterator[None]:
    """Make SIGINT raise, since background processes may ignore it, and restore it at the end."""
    handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    for number, handler in handlers.items():
        signal.signal(number, handler)
