"""The command ``warehouse report``: its output, its files and its errors."""

from pathlib import Path
from typing import Any

import pytest
from helpers.command_line import Refused, Warehouse
from helpers.results_files import fill, outcomes
from helpers.sweeps import Here, run_missing

from agents.lab.experiments.plan import make_plan
from agents.lab.experiments.store import Store
from agents.lab.reports import page as page_module
from agents.lab.reports import report
from agents.lab.reports.page import Page, make_page

ON, OFF = {"escape": True, "max_steps": 30}, {"escape": False, "max_steps": 30}


@pytest.fixture
def results(tmp_path: Path) -> Path:
    return fill(tmp_path / "r.sqlite", [(ON, outcomes("dddw")), (OFF, outcomes("dooo"))])


def test_the_command_prints_the_answers_and_writes_the_page_and_nothing_else(
    results: Path, warehouse: Warehouse
) -> None:
    before = results.read_bytes()
    code, out, err = warehouse("report", results, "--no-replays")
    assert (code, err) == (0, "")
    lines = out.splitlines()
    assert lines[0] == "8 episodes in 2 combinations of settings, seeds from 0 to 3"
    assert "Does escaping loops cut delivery time, or does it make the robot wander?" in lines
    assert "Outcomes with escape off are 75% oscillation and 25% delivered (4 episodes)." in lines
    assert lines[-1] == f"saved {results.with_suffix('.html')}"
    page = results.with_suffix(".html").read_text(encoding="utf-8")
    assert page.startswith("<!DOCTYPE html>")
    assert "Outcomes with escape off are 75% oscillation and 25% delivered (4 episodes)." in page
    assert "<iframe" not in page
    assert results.read_bytes() == before
    assert {path.name for path in results.parent.iterdir()} == {"r.sqlite", "r.html"}


def test_the_page_is_written_even_if_the_output_is_closed(
    results: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def echo(*_: object, **__: object) -> None:
        raise BrokenPipeError

    monkeypatch.setattr(report.typer, "echo", echo)
    with pytest.raises(BrokenPipeError):
        report.report(results, figures=results.parent / "figures", replays=False)
    assert results.with_suffix(".html").exists()
    assert (results.parent / "figures" / "modes.svg").exists()


def test_each_outcome_is_replayed(tmp_path: Path, warehouse: Warehouse) -> None:
    results = tmp_path / "r.sqlite"
    with Store(results) as store:
        run_missing(
            make_plan({"max_steps": 12, "battery": [2, 20], "stations": ["drawn", "kept"]}, 3, 0),
            store,
            Here(),
        )
    assert warehouse("report", results).code == 0
    with Store(results, read_only=True) as store:
        modes = {mode for (mode,) in store.query("SELECT DISTINCT mode FROM episodes")}
    page = results.with_suffix(".html").read_text(encoding="utf-8")
    assert len(modes) > 1
    assert page.count("<iframe") == len(modes)
    assert "run again: " not in page
    assert "different now" not in page
    assert "<td>kept</td>" in page


def test_invalid_results_and_outputs_are_errors(
    results: Path, tmp_path: Path, refused: Refused
) -> None:
    empty = tmp_path / "empty.sqlite"
    Store(empty).close()
    assert refused("report", empty) == f"{empty}: the file has no episodes"
    text = tmp_path / "r.txt"
    text.write_text("no results" * 100)
    assert refused("report", text).startswith(f"{text}: ")
    nowhere = tmp_path / "nowhere" / "page.html"
    assert str(nowhere.parent) in refused("report", results, "-o", nowhere)


def part_of(page: Page, title: str) -> Any:
    [section] = [each for each in page.sections if each.title == title]
    return section.parts


def page_of(*cases: Any) -> Page:
    with Store(fill(Path("page.sqlite"), cases), read_only=True) as store:
        return make_page(store)


def test_a_long_table_ends_with_the_number_of_further_combinations(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(page_module, "MAX_CASES", 1)
    page = page_of((ON, outcomes("dddw")), (OFF, outcomes("dooo")))
    [short] = part_of(page, "All cases")
    assert (len(short.rows), short.caption) == (1, "The file has 1 further combination.")


def test_the_summary_states_what_is_missing_and_the_settings_leave_it_out() -> None:
    page = page_of((ON, outcomes("dd")), (OFF, outcomes("ddd")), ({"battery": 33}, []))
    assert page.intro == [
        "5 episodes in 2 combinations of settings, seeds from 0 to 2, 2 to 3 episodes each, "
        "1 further combination not yet started"
    ]
    [settings] = part_of(page, "Settings")
    assert "33" not in dict(settings.rows)["battery"]
