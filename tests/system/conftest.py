"""A display for the tests that open windows, a browser for those that open pages, and a server."""

import http.server
import os
import shutil
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
from helpers.handbook import HANDBOOK
from helpers.player_pages import Files, Shown, headless_chromium, shown
from helpers.windows import Shower, stop


@pytest.fixture(scope="module")
def display() -> Iterator[str]:
    """Yield the name of a new X display."""
    for program in ("Xvfb", "xdotool"):
        if shutil.which(program) is None:
            pytest.fail(f"{program} is not installed, and window tests need it (xvfb, xdotool)")
    reading, writing = os.pipe()
    # Without -noreset, Xvfb restarts whenever its last client disconnects.
    options = ["-screen", "0", "1400x1000x24", "-nolisten", "tcp", "-noreset"]
    server = subprocess.Popen(
        ["Xvfb", "-displayfd", str(writing), *options],
        pass_fds=[writing],
        stderr=subprocess.DEVNULL,
    )
    try:
        os.close(writing)
        with open(reading, encoding="ascii") as pipe:
            number = pipe.readline().strip()
        assert number, "Xvfb did not start"
        yield f":{number}"
    finally:
        stop(server)


@pytest.fixture
def start(display: str, tmp_path: Path) -> Iterator[Callable[..., Shower]]:
    """Return a function that starts a program with a window, which ends with the test."""
    with ExitStack() as stack:

        def begin(*words: object) -> Shower:
            program = Shower(display, tmp_path, *words)
            stack.callback(program.close)
            return program

        yield begin


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    """Yield a headless Chromium, driven by Playwright."""
    with headless_chromium() as chromium:
        yield chromium


@pytest.fixture(scope="session")
def files(tmp_path_factory: pytest.TempPathFactory) -> Files:
    """Return a function that writes pages, each once."""
    return Files(tmp_path_factory.mktemp("pages"))


@pytest.fixture
def opened(browser: Any) -> Iterator[Callable[..., Shown]]:
    """Return a function that opens a file in a page of its own, which is checked at the end."""
    with ExitStack() as stack:

        def open_file(file: Path, **options: Any) -> Shown:
            return stack.enter_context(shown(browser, **options)).open(file)

        yield open_file


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Keep the tests of the site together, so that only one of several processes builds it."""
    for item in items:
        is_of_the_site = "site" in getattr(item, "fixturenames", ())
        if is_of_the_site and config.pluginmanager.hasplugin("xdist"):
            item.add_marker(pytest.mark.xdist_group("site"))


@pytest.fixture(scope="session")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the site of the handbook and return its folder."""
    folder = tmp_path_factory.mktemp("site")
    words = ["-m", "sphinx", "-q", "-W", "-E", "-d", str(folder / "trees")]
    done = subprocess.run(
        [sys.executable, *words, str(HANDBOOK), str(folder / "html")],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    return folder / "html"


@pytest.fixture
def server() -> Iterator[tuple[str, list[str]]]:
    """Yield the address of a server, and a list of the paths requested from it."""
    requested: list[str] = []

    class Handler(http.server.BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            requested.append(self.path)
            self.send_response(404)
            self.end_headers()

        def log_message(self, format: str, *_: object) -> None:  # noqa: A002
            pass

    listener = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    thread = threading.Thread(target=listener.serve_forever)
    thread.start()
    try:
        yield f"http://127.0.0.1:{listener.server_port}", requested
    finally:
        listener.shutdown()
        thread.join()
        listener.server_close()
