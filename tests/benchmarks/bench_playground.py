"""The playground in headless Chromium: its size, its first animation, and steps per second."""

from collections.abc import Callable, Iterator
from os import cpu_count, getloadavg
from pathlib import Path
from statistics import median
from time import perf_counter
from typing import Any

import pytest
from helpers import wasm_speed
from helpers.player_pages import headless_chromium
from helpers.playground import MAX_DOWNLOAD, Playground, run_in_node, write_page
from helpers.servers import served

MIN_STEPS = 15_000
"""Minimum number of steps per second."""

MAX_COLD, MAX_WARM = 30.0, 8.0
"""Maximum seconds from a click to the first animation, with an empty and with a full cache."""

ROUNDS = 3

Measured = Callable[[str, object], None]


@pytest.fixture(scope="module")
def page_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_page(tmp_path_factory.mktemp("playground"))


@pytest.fixture
def browser() -> Iterator[Any]:
    with headless_chromium() as chromium:
        yield chromium


def test_the_core_with_pyodide_in_node(page_folder: Path, measured: Measured) -> None:
    steps = [float(line) for line in run_in_node(page_folder, Path(wasm_speed.__file__)).split()]
    with_random, with_greedy = (f"{each:,.0f}" for each in steps)
    measured(
        "steps per second in the default warehouse, with Pyodide in Node.js",
        f"{with_random} with random actions, {with_greedy} with the greedy agent",
    )
    assert min(steps) >= MIN_STEPS


def test_the_first_animation_of_the_playground(page_folder: Path, browser: Any, measured) -> None:
    cold, warm, sizes = [], [], set()
    with served(page_folder) as address:
        for _ in range(ROUNDS):  # each with an empty cache
            context = browser.new_context(viewport={"width": 1366, "height": 768})
            for times in (cold, warm):
                seconds, size = first_animation(context, address)
                times.append(seconds)
                sizes.add(size)
            context.close()
    measured(
        f"from a click to the first animation of the playground, median of {ROUNDS}",
        f"{median(cold):.1f} s with an empty cache, {median(warm):.1f} s with a full cache, "
        f"{max(sizes) / 1e6:.1f} MB; {getloadavg()[0] / (cpu_count() or 1):.1f} running processes "
        "per processor",
    )
    assert max(sizes) <= MAX_DOWNLOAD
    assert median(cold) <= MAX_COLD
    assert median(warm) <= MAX_WARM


def first_animation(context: Any, address: str) -> tuple[float, int]:
    """Return the seconds until a new page plays an episode, and the number of bytes loaded."""
    page, start = context.new_page(), perf_counter()
    playground = Playground(page, address)
    playground.press("run")
    playground.wait_for_player()
    seconds = perf_counter() - start
    page.close()
    return seconds, playground.size
