"""The command ``warehouse gap``."""

import csv
import re
from math import inf, nan
from pathlib import Path
from typing import Any

import pytest
from helpers.command_line import Warehouse
from helpers.player import page_in, said_by

from agents.lab.commands.gap.spent_time import KINDS
from agents.lab.commands.gap.summary import gap_table, losses, message
from agents.lab.commands.gap.trial import Score
from agents.lab.commands.gap.worlds import (
    ALONE,
    DISTURBED,
    DRIVING,
    PLAN,
    STOPPING,
    WORLDS,
    Shocks,
)

SMALL = (
    "compare", "backends", "--robots", 2, "--count", 3, "--order-rate", 0.1, "--seed", 5,
    "--jobs", 1, "--stop", 5, "--layout", "shelves",
)  # fmt: skip
PLAIN = Score(100.0, 1.0, 2000.0, 0, 144.0, 4, 0, (1.0, 0.0, 0.0, 0.0, 0.0), 0)
NO_SHOCKS = Shocks(0.0, 0.0)


def caption_at(track: Any, moment: float) -> str:
    """Return the caption that a page shows of a track at a moment."""
    frame = sum(time <= moment + 1e-9 for time in track["time"]) - 1
    caption: str = track["captions"][track["captionAt"][frame]]
    return caption


def scores(
    stopping: float, driving: float, disturbed: float, alone: float = 1.0
) -> dict[str, list[Score]]:
    """Return scores of two seeds, the second half as fast, with shares of the plan's deliveries."""
    shares = dict(zip(WORLDS, (1.0, stopping, alone, driving, disturbed), strict=True))
    return {
        world: [PLAIN._replace(per_hour=rate * share) for rate in (100.0, 50.0)]
        for world, share in shares.items()
    }


def test_worlds_are_compared_in_a_table_a_page_and_a_file_of_values(warehouse: Warehouse) -> None:
    code, out, _ = warehouse(*SMALL, "-n", 2, "--save", "gap.html", "--save", "gap.csv")
    assert code == 0
    lines = Path("gap.csv").read_text(encoding="utf-8").splitlines()
    rows = {row["world"] + row["seed"]: row for row in csv.DictReader(lines)}
    assert list(rows) == [f"{world}{seed}" for world in WORLDS for seed in (5, 6)]
    for row in rows.values():
        assert (row["delivered"], row["lost"]) == ("3", "0")
        assert float(row["per_hour"]) == pytest.approx(3 / float(row["makespan"]) * 3600)
        spent = [float(row[f"seconds a delivery {kind}"]) for kind in KINDS]
        # The record ends in the first step of the last drop, a quarter of a second if robots drive.
        rest = 0.75 if row["world"] in (ALONE, DRIVING, DISTURBED) else 0.0
        assert sum(spent) == pytest.approx(2 * (float(row["makespan"]) - rest) / 3)
    means = {
        world: sum(float(rows[f"{world}{seed}"]["makespan"]) for seed in (5, 6)) / 2
        for world in WORLDS
    }
    assert means[PLAN] < means[DRIVING] < means[STOPPING]
    assert all(f" {makespan:.3g} " in out for makespan in means.values())
    [said] = re.findall(r"^Driving through brings .*(?=\.$)", out, flags=re.MULTILINE)
    page = Path("gap.html").read_text(encoding="utf-8")
    [heading] = re.findall(r"After ([\d,]+) s the plan has delivered 3 orders, (.*)</h2>", page)
    player = said_by(page_in(page))
    captions = [caption_at(track, player["opensAt"]) for track in player["tracks"]]
    counts = [int(caption.split()[0]) for caption in captions]
    assert f"{player['opensAt']:.0f}" == heading[0], "the floors show what the heading tells"
    assert counts == [3, *(int(number) for number in re.findall(r" (\d+)", heading[1]))]
    assert counts[1] < 3
    assert f"<h1>{said}</h1>" in page
    assert page.count("<iframe") == 1
    assert "http" not in page.replace("http-equiv", "").replace("http://www.w3.org", "")


def test_the_message_has_the_mean_of_the_shares_of_each_seed() -> None:
    found = scores(0.5, 0.9, 0.8, alone=0.95)
    assert message(found, NO_SHOCKS) == (
        "Driving through brings 90% of what the plan promises, 95% if robots do not meet, stopping "
        "in every cell 50%"
    )
    assert "(80% with 5% noise and a stop of 60 s)" in message(found, Shocks(0.05, 60.0))
    assert "(80% with a dead robot)" in message(found, Shocks(0.0, inf))


def test_intervals_of_shares_are_of_pairs() -> None:
    many = {world: runs * 10 for world, runs in scores(0.5, 0.9, 0.8).items()}
    rows = {name: cells for name, *cells in gap_table(many, "").rows}
    assert re.fullmatch(r"75\.0\n\(\d\d\.\d to \d\d\.\d\)", rows[PLAN][0])
    assert [rows[world][1] for world in WORLDS] == ["100", "50", "100", "90", "80"]


def test_a_plan_that_delivers_nothing_has_no_shares() -> None:
    nothing = {world: [PLAIN._replace(per_hour=0.0)] for world in WORLDS}
    assert [cells[2] for cells in gap_table(nothing, "").rows] == ["none"] * 5
    assert message(nothing, NO_SHOCKS).startswith("Driving through brings none of what the plan")
    half = {world: [*runs, PLAIN] for world, runs in nothing.items()}
    assert [cells[2] for cells in gap_table(half, "").rows] == ["100"] * 5


def test_what_is_lost_is_said() -> None:
    found = scores(1.0, 1.0, 1.0)
    assert losses(found, 4) == []
    found[DISTURBED][1] = PLAIN._replace(delivered=3, lost=1, on_time=nan)
    assert losses(found, 4) == ["disturbed, in 2 episodes: 1 order not delivered and 1 robot lost"]
