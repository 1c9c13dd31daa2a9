"""Pyodide in node and Chromium gives the same results as CPython; ``.ci/pyodide`` fetches it."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from helpers import wasm_digests
from helpers.playground import MAX_DOWNLOAD, Playground, run_by_cpython, run_in_node, write_page
from helpers.servers import served

from agents.lab.grading.rubric import MINI_LAB, SOLUTIONS
from agents.lab.playground.session import Session
from warehouse_core import DEFAULT_LAYOUT

pytestmark = pytest.mark.wasm

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
    return write_page(tmp_path_factory.mktemp("playground"))


def test_node_has_the_digests_of_cpython(page_folder: Path) -> None:
    script = Path(wasm_digests.__file__)
    cpython = run_by_cpython(script)
    pyodide = run_in_node(page_folder, script)
    assert len(cpython.splitlines()) > 20
    assert pyodide == cpython


@pytest.fixture(scope="module")
def address(page_folder: Path) -> Iterator[str]:
    """Yield the address of a server of the page."""
    with served(page_folder) as found:
        yield found


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
START = {
    "exercise": "mini_lab",
    "code": CODE,
    "rows": DEFAULT_LAYOUT.rows,
    "seed": 1,
    "stations": "drawn",
}


def test_the_page_runs_and_grades_as_cpython_does(playground: Playground, tmp_path: Path) -> None:
    playground.press("run")
    assert (
        playground.text("summary") == answered(tmp_path, {"do": "run", "start": START})["summary"]
    )
    playground.wait_for_player()
    playground.press("step")
    playground.press("step")
    assert playground.text("summary").startswith("2 steps")
    playground.press("grade")
    grade = answered(tmp_path, {"do": "grade", "code": CODE, "exercise": "mini_lab"})
    assert playground.text("summary") == grade["summary"]
    assert playground.page.locator("[data-part=grades] tr").count() == len(grade["grades"])
    assert playground.errors == []


def test_an_exercise_is_chosen_and_graded_and_code_of_the_other_is_kept(playground) -> None:
    playground.page.select_option("[data-part=exercise]", "exercise-02")
    assert "def distance" in playground.page.input_value("[data-part=code]")
    playground.press("grade")
    assert "of 100 points" in playground.text("summary")
    playground.type((SOLUTIONS / "exercise-02.py").read_text(encoding="utf-8"))
    playground.press("grade")
    assert playground.text("summary").startswith("100 of 100 points")
    playground.page.set_viewport_size({"width": 360, "height": 800})
    assert playground.page.evaluate("document.documentElement.scrollWidth") == 360
    playground.page.set_viewport_size({"width": 1366, "height": 768})
    playground.page.select_option("[data-part=exercise]", "exercise-08")
    assert playground.page.input_value("[data-part=layout]") == "maze"
    playground.page.select_option("[data-part=exercise]", "mini_lab")
    assert playground.page.input_value("[data-part=code]") == CODE
    assert playground.page.input_value("[data-part=layout]") == "default"
    assert playground.errors == []


def test_the_page_asks_its_own_server_alone_and_for_little(playground, address) -> None:
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
    assert "unreachable" in playground.text("summary") or "no path" in playground.text("summary")
    assert playground.page.input_value("[data-part=layout]") == "painted"
