"""Live pages of the handbook in headless Chromium: size, and seconds to the first player.

The server of these measurements does not compress; the size is also told for one that does.
"""

from collections.abc import Callable
from os import cpu_count, getloadavg
from pathlib import Path
from statistics import median
from time import perf_counter

import pytest
from helpers.live import LivePage, write_site
from helpers.player_pages import headless_chromium
from helpers.playground import served

MAX_COLD = 30.0
"""Seconds from a click on a link to the first player, with nothing in the cache."""

ROUNDS = 3


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_site(tmp_path_factory.mktemp("site"))


@pytest.mark.parametrize("name", ["mini_lab", "fleet"])
def test_the_first_player_of_a_live_page(
    name: str, site: Path, measured: Callable[[str, object], None]
) -> None:
    cold, warm, sizes, compressed = [], [], [], []
    with headless_chromium() as browser, served(site) as address:
        for _ in range(ROUNDS):  # each with an empty cache
            with browser.new_context() as context:
                for times in (cold, warm):
                    page, start = context.new_page(), perf_counter()
                    reading = LivePage(page, address, name)
                    reading.run()
                    reading.wait_for_player()
                    times.append(perf_counter() - start)
                    reading.wait_for_end()
                    sizes.append(reading.size)
                    compressed.append(reading.compressed(site))
                    page.close()
    measured(
        f"from a click to the first player of the live page {name}, median of {ROUNDS}",
        f"{median(cold):.1f} s cold, {median(warm):.1f} s warm, {max(sizes) / 1e6:.1f} MB, "
        f"{max(compressed) / 1e6:.1f} MB compressed; "
        f"{getloadavg()[0] / (cpu_count() or 1):.1f} running processes for each processor",
    )
    assert median(cold) <= MAX_COLD
