"""Pyodide, in node and in headless Chromium, does what CPython does; ``.ci/pyodide`` fetches it."""

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from helpers import wasm_digests, wasm_pages
from helpers.handbook import WRITE
from helpers.live import LivePage, cells_of, write_site
from helpers.playground import (
    MAX_DOWNLOAD,
    Playground,
    run_by,
    run_by_cpython,
    run_in_node,
    served,
    write_page,
)

from agents.handbook import live
from agents.lab.grading.exercises import SOLUTIONS
from agents.lab.grading.rubric import MINI_LAB
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
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of the handbook's site with live pages."""
    return write_site(tmp_path_factory.mktemp("site"))


@pytest.mark.parametrize("page", [page.stem for page in live.pages() if cells_of(page.stem)])
def test_a_live_page_says_in_node_what_it_says_in_cpython(
    page: str, site: Path, tmp_path: Path
) -> None:
    cells = cells_of(page)
    script, loaded = tmp_path / "cells_of_a_page.py", tmp_path / "loaded.py"
    source = Path(wasm_pages.__file__).read_text(encoding="utf-8")
    script.write_text(f"{source}\n\nrun_cells({cells!r})\n", encoding="utf-8")
    imported = [cell for cell in cells if not cell.startswith(WRITE)]
    loaded.write_text("\n".join(imported), encoding="utf-8")
    cpython = run_by_cpython(script)
    assert len(cpython.splitlines()) >= len(cells)
    assert run_by(site / live.FOLDER / live.RUNTIME, script, loaded) == cpython


def test_each_page_with_cells_links_to_its_notebook_and_others_to_none(site: Path) -> None:
    live_pages = {page.stem for page in live.pages()}
    for file in site.glob("*.html"):
        text = file.read_text(encoding="utf-8")
        links = re.findall(r'href="(live/[^"?]*)\?path=([^"]*)"', text)
        wanted = [("live/notebooks/index.html", f"{file.stem}.ipynb")]
        assert links == (wanted if file.stem in live_pages else []), file.name
    assert (site / "live/notebooks/index.html").exists()
    assert {file.stem for file in (site / "live/files").glob("*.ipynb")} == live_pages


def test_a_live_page_runs_and_asks_its_own_server_alone(browser: Any, site: Path) -> None:
    with served(site) as address, browser.new_context() as context:
        reading = LivePage(context.new_page(), address, "mini_lab")
        reading.run()
        reading.wait_for_player()
        reading.wait_for_end()
        outputs = "\n".join(reading.outputs)
        assert "delivered 23 12.7" in outputs
        assert "Writing my_layout.txt" in outputs  # by one of the last cells
        assert reading.red == []
        assert 10_000_000 < reading.compressed(site) < MAX_DOWNLOAD
        assert [url for url in reading.requests if not url.startswith((address, "blob:"))] == []
        assert [url for url in reading.requests if url.endswith(".whl")] != []
        assert reading.errors == []


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
    assert playground.text("told") == answered(tmp_path, {"do": "run", "start": START})["told"]
    playground.wait_for_player()
    playground.press("step")
    playground.press("step")
    assert playground.text("told").startswith("2 steps")
    playground.press("grade")
    grade = answered(tmp_path, {"do": "grade", "code": CODE, "exercise": "mini_lab"})
    assert playground.text("told") == grade["told"]
    assert playground.page.locator("[data-part=grades] tr").count() == len(grade["grades"])
    assert playground.errors == []


def test_an_exercise_is_chosen_and_graded_and_code_of_the_other_is_kept(
    playground: Playground,
) -> None:
    playground.page.select_option("[data-part=exercise]", "exercise-02")
    assert "def distance" in playground.page.input_value("[data-part=code]")
    playground.press("grade")
    assert "of 100 points" in playground.text("told")
    playground.type((SOLUTIONS / "exercise-02.py").read_text(encoding="utf-8"))
    playground.press("grade")
    assert playground.text("told").startswith("100 of 100 points")
    playground.page.set_viewport_size({"width": 360, "height": 800})
    assert playground.page.evaluate("document.documentElement.scrollWidth") == 360
    playground.page.set_viewport_size({"width": 1366, "height": 768})
    playground.page.select_option("[data-part=exercise]", "exercise-08")
    assert playground.page.input_value("[data-part=layout]") == "maze"
    playground.page.select_option("[data-part=exercise]", "mini_lab")
    assert playground.page.input_value("[data-part=code]") == CODE
    assert playground.page.input_value("[data-part=layout]") == "default"
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
