"""The command ``warehouse race``."""

import re
from pathlib import Path
from typing import Any

import pytest
from helpers.command_line import Warehouse, write_mine
from helpers.player import said_by
from PIL import Image

from agents.lab.commands.race import RACERS, TITLES

MAX_BYTES = 250_000


def caption_at(track: Any, moment: float) -> str:
    """Return the caption of a track at the end of a step, or at a time in seconds."""
    frame = max(n for n, time in enumerate(track["time"]) if time <= moment + 1e-6)
    caption: str = track["captions"][track["captionAt"][frame]]
    return caption


@pytest.mark.parametrize("backend", ["grid", "physics"])
def test_the_story_of_the_first_day_on_one_page(warehouse: Warehouse, backend: str) -> None:
    code, out, err = warehouse("race", "--backend", backend, "--save", "race.html")
    assert (code, err) == (0, "")
    page = Path("race.html").read_text(encoding="utf-8")
    assert len(page.encode()) <= MAX_BYTES
    said = said_by(page)
    tracks = {track["title"]: track for track in said["tracks"]}
    assert list(tracks) == [TITLES[name] for name in RACERS]
    assert said["charts"] == []
    steps = {title: round(track["progress"][-1]) for title, track in tracks.items()}
    best = steps["A*"]
    assert best == steps["Q-learning"] < steps["exploring"] < steps["greedy"] < 60
    endings = [track["ending"] for track in tracks.values()]
    assert endings == ["oscillation", *["delivered"] * 4]
    for title, track in tracks.items():
        assert track["captions"][1].startswith("goes to the item: "), "from the first moment on"
        assert f"{title}: {track['captions'][-1]}." in out.replace("\n", " ")
    late = tracks["A*"]["time"][-1] * 1.5
    assert caption_at(tracks["greedy without escape"], late).startswith("goes in circles: ")
    assert caption_at(tracks["A*"], late) == tracks["A*"]["captions"][-1]


def test_own_agents_race_once_each_and_one_that_fails_is_named(warehouse: Warehouse) -> None:
    write_mine("act", "raise ValueError('too far')", "'N'")
    agents = ("--agent", "astar", "--agent", "astar", "--agent", "mine.py:Mine")
    done = warehouse("race", *agents[:4], "--max-steps", 5, "--save", "race.png")
    assert done.out.count("A*: ") == 1
    with Image.open("race.png") as picture:
        assert picture.width > 100
    failed = warehouse("race", *agents, "--save", "race.html")
    assert failed.code == 1
    assert re.search(r"seed 35, step \d+, agent mine.py:Mine: ValueError: too far", failed.err)
    assert not Path("race.html").exists()
