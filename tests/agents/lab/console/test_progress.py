import io
import re
import sys
import time

import pytest
from helpers.terminal import Terminal

from agents.lab.console.progress import progress_bar, track


def shown(monkeypatch: pytest.MonkeyPatch, screen: io.StringIO, *steps: int) -> str:
    """Return the output of a bar."""
    monkeypatch.setattr(sys, "stderr", screen)
    monkeypatch.setenv("COLUMNS", "100")
    monkeypatch.setenv("TERM", "xterm")
    with progress_bar(200, "Q-learning") as advance:
        for completed in steps:
            time.sleep(0.02)
            advance(completed, f"{completed} seen")
    return re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", screen.getvalue())


def test_a_terminal_gets_a_bar_with_count_times_and_news(monkeypatch: pytest.MonkeyPatch) -> None:
    line = re.split(r"[\r\n]+", shown(monkeypatch, Terminal(), 40, 100).strip())[-1]
    assert re.search(r"Q-learning [━╸╺ ]+ 100/200 \d:\d\d:\d\d \d:\d\d:\d\d 100 seen", line)


def test_without_a_terminal_there_is_no_bar_but_a_line_a_minute(monkeypatch) -> None:
    assert shown(monkeypatch, io.StringIO(), 100) == ""
    now = 5.0
    monkeypatch.setattr(time, "monotonic", lambda: now)
    screen = io.StringIO()
    monkeypatch.setattr(sys, "stderr", screen)
    with progress_bar(20_000, "Q-learning") as advance:
        for step in range(130):
            now += 1
            advance(step * 100, "delivers 5%")
    assert screen.getvalue() == (
        "Q-learning: 5,900 of 20,000 in 0:01:00, delivers 5%\n"
        "Q-learning: 11,900 of 20,000 in 0:02:00, delivers 5%\n"
    )


def test_a_command_in_a_notebook_has_a_terminal_but_no_bar(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("JPY_PARENT_PID", "1")
    assert shown(monkeypatch, Terminal(), 100) == ""


def test_track_yields_every_item_and_counts_them(monkeypatch: pytest.MonkeyPatch) -> None:
    screen = Terminal()
    monkeypatch.setattr(sys, "stderr", screen)
    assert list(track("abc", "letters")) == ["a", "b", "c"]
    assert "3/3" in screen.getvalue()
