"""The progress bar of a sweep."""

import io
import re
import sys
import time
from collections.abc import Sequence

import pytest
from helpers.results_files import fleet_row
from helpers.terminal import Terminal

from agents.lab.experiments.sweep import sweep_bar
from agents.lab.trials.rows import AnyRow, Row


def rows(*modes: str) -> list[Row]:
    return [Row(seed, mode, 1, 1, 0, 0, 0, 0, 0, 0) for seed, mode in enumerate(modes)]


def shown(monkeypatch: pytest.MonkeyPatch, screen: io.StringIO, *news: Sequence[AnyRow]) -> str:
    """Return what a bar for 8 episodes writes."""
    monkeypatch.setattr(sys, "stderr", screen)
    monkeypatch.setenv("COLUMNS", "100")
    monkeypatch.setenv("TERM", "xterm")
    with sweep_bar(8, lambda: None) as report:
        for each in news:
            time.sleep(0.02)  # without it the rate would be too large for the line
            report(each, [])
    return re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", screen.getvalue())


def last_line(text: str) -> str:
    return re.split(r"[\r\n]+", text.strip())[-1]


def test_a_terminal_shows_the_count_the_rate_the_time_left_and_the_share_delivered(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    some = rows("delivered", "stalled", "delivered")
    line = last_line(shown(monkeypatch, Terminal(), some, [], rows("wandering")))
    assert re.search(r"[━╸╺ ]+ 4/8 [\d,]+/s \d:\d\d:\d\d 50% delivered", line), line


@pytest.mark.parametrize(
    ("news", "ending"),
    [
        ([rows("delivered"), rows("stalled"), rows("stalled", "stalled")], " 4/8 .* 25% delivered"),
        ([[fleet_row(0), fleet_row(1, delivered=1)]], " 2/8 .* 30% delivered"),
    ],
    ids=["episodes of lone robots", "orders of fleets"],
)
def test_the_share_is_of_all_so_far(
    monkeypatch: pytest.MonkeyPatch, news: list[list[AnyRow]], ending: str
) -> None:
    assert re.search(f"{ending} *$", last_line(shown(monkeypatch, Terminal(), *news)))


def test_the_share_is_left_out_until_it_is_known_and_all_without_a_terminal(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert shown(monkeypatch, io.StringIO(), rows("delivered")) == ""
    text = shown(monkeypatch, Terminal(), [])
    assert "0/8" in text
    assert "delivered" not in text
    assert "None" not in text


def test_a_failure_that_comes_again_is_told_once(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with sweep_bar(8, lambda: None) as report:
        for failures in (["a is broken", "a is broken"], ["a is broken", "b is broken"]):
            report([], failures)
    lines = sorted(capsys.readouterr().err.splitlines())
    assert lines == ["warehouse: a is broken", "warehouse: b is broken"]
