"""Pyodide, in node and in headless Chromium, does what CPython does; ``.ci/pyodide`` fetches it."""

import http.server
import json
import os
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from time import monotonic, sleep
from typing import Any

import pytest
from helpers import wasm_digests
from helpers.command_line import ROOT

from agents.lab.grading.rubric import MINI_LAB
from agents.lab.playground.page import RUNTIME, write_playground
from agents.lab.playground.session import Session
from warehouse_core import DEFAULT_LAYOUT

pytestmark = pytest.mark.wasm

FILES = ROOT / ".venv" / "pyodide"
MAX_DOWNLOAD = 25_000_000
SECONDS = 120

LOOP = """class Agent:
    def reset(self):
        pass

    def act(self, observation):
        while True:
            pass
"""


@pytest.fixture(scope="module")
def page_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a playground."""
    assert FILES.is_dir(), f"{FILES} is missing; .ci/pyodide fetches it"
    folder = tmp_path_factory.mktemp("playground")
    write_playground(folder, str(FILES))
    return folder


def test_node_has_the_digests_of_cpython(page_folder: Path) -> None:
    [wheel] = page_folder.glob("*.whl")
    helpers, script = ROOT / "tests" / "helpers", wasm_digests.__file__
    node = ["node", str(helpers / "pyodide.mjs"), str(page_folder / RUNTIME), str(wheel), script]
    environment = os.environ | {"WAREHOUSE_FAST": "0"}
    cpython, pyodide = (
        subprocess.run(words, capture_output=True, text=True, env=environment, check=True).stdout
        for words in ([sys.executable, script], node)
    )
    assert len(cpython.splitlines()) > 20
    assert pyodide == cpython


@pytest.fixture(scope="module")
def address(page_folder: Path) -> Iterator[str]:
    """Yield the address of a server of the page."""

    class Quiet(http.server.SimpleHTTPRequestHandler):
        def log_message(self, *_: object) -> None:
            pass

    handler = partial(Quiet, directory=page_folder)
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/"
        server.shutdown()


class Playground:
    """The page in a browser, and what it has loaded."""

    def __init__(self, page: Any, address: str) -> None:
        self.page, self.errors, self.requests = page, list[str](), list[str]()
        self.size = 0
        page.on("pageerror", lambda error: self.errors.append(str(error)))
        page.on("console", lambda message: self.errors.append(message.text))
        page.on("request", lambda request: self.requests.append(request.url))
        page.on("response", self._count)
        page.goto(address)
        self.until(lambda: page.is_enabled("[data-do=run]"))

    def _count(self, response: Any) -> None:
        self.size += int(response.headers.get("content-length", 0))

    def until(self, is_so: Callable[[], Any]) -> None:
        """Wait until something is so; the page's policy forbids that the browser evaluates it."""
        end = monotonic() + SECONDS
        while not is_so():
            assert monotonic() < end, (self.text("state"), self.text("error"), self.errors)
            sleep(0.05)

    def text(self, part: str) -> str:
        found: str = self.page.locator(f"[data-part={part}]").inner_text()
        return found

    def press(self, name: str) -> None:
        """Press a button, and wait until what it does is done."""
        self.page.click(f"[data-do={name}]")
        self.until(lambda: self.page.is_enabled("[data-do=run]"))

    def type(self, code: str) -> None:
        self.page.fill("[data-part=code]", code)


@pytest.fixture(scope="module")
def playground(browser: Any, address: str) -> Iterator[Playground]:
    page = browser.new_page(viewport={"width": 1366, "height": 768})
    yield Playground(page, address)
    page.close()


def answered(tmp_path: Path, question: dict[str, Any]) -> Any:
    """Return CPython's answer to a question."""
    session = Session(tmp_path / "agent.py")
    return json.loads(session.answer(json.dumps(question), lambda done, total: None))


CODE = MINI_LAB.with_suffix(".py").read_text(encoding="utf-8")
START = {"code": CODE, "rows": DEFAULT_LAYOUT.rows, "seed": 1, "stations": "drawn"}


def test_the_page_runs_and_grades_as_cpython_does(playground: Playground, tmp_path: Path) -> None:
    playground.press("run")
    assert playground.text("told") == answered(tmp_path, {"do": "run", "start": START})["told"]
    player = playground.page.frame_locator("[data-part=player]")
    player.locator("canvas").first.wait_for()
    playground.press("step")
    playground.press("step")
    assert playground.text("told").startswith("2 steps")
    playground.press("grade")
    grade = answered(tmp_path, {"do": "grade", "code": CODE})
    assert playground.text("told") == grade["told"]
    assert playground.page.locator("[data-part=grades] tr").count() == len(grade["grades"])
    assert playground.errors == []


def test_the_page_asks_its_own_server_alone_and_for_little(
    playground: Playground, address: str
) -> None:
    assert [url for url in playground.requests if not url.startswith((address, "about:"))] == []
    assert 10_000_000 < playground.size < MAX_DOWNLOAD


def test_an_endless_loop_is_ended_and_the_page_goes_on(playground: Playground) -> None:
    playground.type(LOOP)
    playground.press("run")
    assert "endless loop" in playground.text("error")
    playground.type("class Agent:\n    pass\n")
    playground.press("run")
    assert "0 classes with reset and act" in playground.text("error")


def test_code_is_kept_and_a_link_has_it(playground: Playground, browser: Any) -> None:
    playground.type(LOOP)
    playground.page.click("[data-do=share]")
    playground.until(lambda: "link" in playground.text("state"))
    assert "#p=" in playground.page.url
    with browser.new_context() as other:
        page = other.new_page()
        page.goto(playground.page.url)
        page.wait_for_selector(".numbers span")
        assert page.input_value("[data-part=code]") == LOOP
    playground.page.goto(playground.page.url.partition("#")[0])
    playground.page.wait_for_selector(".numbers span")
    assert playground.page.input_value("[data-part=code]") == LOOP


def test_a_painted_layout_is_that_of_the_episode(playground: Playground) -> None:
    playground.until(lambda: playground.page.is_enabled("[data-do=run]"))
    playground.page.click("summary")
    playground.page.select_option("[data-part=layout]", "corridor")
    cell = playground.page.locator("[data-row='1'][data-column='5']")
    cell.click()
    assert cell.get_attribute("data-tile") == "#"
    playground.type(CODE)
    playground.press("run")
    assert "unreachable" in playground.text("told") or "no path" in playground.text("told")
    assert playground.page.input_value("[data-part=layout]") == "painted"
