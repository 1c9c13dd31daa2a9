"""The bar that shows how far a training has come."""

import io
import math
import re
import sys
import time

import pytest
from helpers.terminal import Terminal

from agents.console.progress import training_bar


def shown(
    monkeypatch: pytest.MonkeyPatch, screen: io.StringIO, *news: tuple[int, float, float]
) -> str:
    """Return what a bar writes."""
    monkeypatch.setattr(sys, "stderr", screen)
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("TERM", "xterm")
    with training_bar("Q-learning", 200) as advance:
        for each in news:
            time.sleep(0.02)  # without it the speed would be too large for the line
            advance(*each)
    return re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", screen.getvalue())


def test_a_terminal_gets_a_bar_with_speed_time_left_and_success(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    text = shown(monkeypatch, Terminal(), (40, 0.5, 0.25), (100, 0.957, 0.875))
    line = re.split(r"[\r\n]+", text.strip())[-1]
    assert line.startswith("Q-learning")
    assert line.rstrip().endswith("left, delivers 96%, exam 88%")
    assert " 50% " in line
    assert re.search(r"[\d,]+ steps/s \d:\d\d:\d\d left", line)


def test_what_is_not_known_yet_is_not_shown_as_a_number(monkeypatch: pytest.MonkeyPatch) -> None:
    text = shown(monkeypatch, Terminal(), (0, math.nan, math.nan))
    assert "delivers -, exam -" in text
    assert "nan" not in text


def test_what_is_no_terminal_gets_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    assert shown(monkeypatch, io.StringIO(), (100, 0.5, 0.5)) == ""
