"""Fleets in four worlds: ``warehouse compare backends --robots N``."""

import csv
import re
from math import inf
from pathlib import Path

import pytest
from helpers.command_line import Refused, Warehouse
from helpers.player import page_in, said_by

from agents.lab.commands.compare_fleets import (
    DISTURBED,
    DRIVING,
    PLAN,
    STOPPING,
    WORLDS,
    Score,
    losses,
    parse_disturbed,
    table_of,
)

SMALL = (
    "compare", "backends", "--robots", 2, "--count", 2, "--order-rate", 0.1, "--seed", 5,
    "--jobs", 1, "--disturbed", "0.05:5", "--layout", "shelves",
)  # fmt: skip
PLAIN = Score(100.0, 1.0, 2000.0, 0, 144.0, 4, 0, 0)


def scores(*shares: float) -> dict[str, list[Score]]:
    """Return scores of two seeds with shares of the plan's deliveries; one is half as fast."""
    return {
        world: [PLAIN._replace(per_hour=rate * share) for rate in (100.0, 50.0)]
        for world, share in zip(WORLDS, shares, strict=True)
    }


def test_worlds_are_compared_in_tables_a_page_and_a_file_of_values(warehouse: Warehouse) -> None:
    code, out, _ = warehouse(*SMALL, "-n", 2, "--save", "a.html", "--save", "a.csv")
    assert code == 0
    lines = Path("a.csv").read_text(encoding="utf-8").splitlines()
    rows = {row["world"] + row["seed"]: row for row in csv.DictReader(lines)}
    assert list(rows) == [f"{world}{seed}" for world in WORLDS for seed in (5, 6)]
    for row in rows.values():
        assert (row["delivered"], row["lost"]) == ("2", "0")
        assert float(row["per_hour"]) == pytest.approx(2 / float(row["makespan"]) * 3600)
    means = {
        world: sum(float(rows[f"{world}{seed}"]["makespan"]) for seed in (5, 6)) / 2
        for world in WORLDS
    }
    assert means[PLAN] < means[DRIVING] < means[STOPPING]
    assert all(f" {makespan:.3g} " in out for makespan in means.values())
    page = Path("a.html").read_text(encoding="utf-8")
    assert [track["title"] for track in said_by(page_in(page))["tracks"]] == [*WORLDS]
    assert page.count("<table") == 1
    assert page.count("<iframe") == 1
    assert "http" not in page.replace("http-equiv", "").replace("http://www.w3.org", "")


def test_intervals_of_shares_come_from_pairs() -> None:
    many = {world: runs * 10 for world, runs in scores(1.0, 0.5, 0.9, 0.8).items()}
    rows = {name: cells for name, *cells in table_of(many, "").rows}
    assert re.fullmatch(r"75\.0\n\(\d\d\.\d to \d\d\.\d\)", rows[PLAN][0])
    assert [rows[world][1] for world in WORLDS] == ["100", "50", "90", "80"]


def test_a_plan_that_delivers_nothing_has_no_shares() -> None:
    nothing = {world: [PLAIN._replace(per_hour=0.0)] for world in WORLDS}
    assert [cells[2] for cells in table_of(nothing, "").rows] == ["none"] * 4
    half = {world: [*runs, PLAIN] for world, runs in nothing.items()}
    assert [cells[2] for cells in table_of(half, "").rows] == ["100"] * 4


def test_losses_are_reported() -> None:
    found = scores(1.0, 1.0, 1.0, 1.0)
    assert losses(found, 4) == []
    found[DISTURBED][1] = PLAIN._replace(delivered=3, lost=1)
    assert losses(found, 4) == ["disturbed, in 2 episodes: 1 order not delivered and 1 robot lost"]


@pytest.mark.parametrize("text", ["0.6:9", "5", "0.1:x", "0.1:-1"])
def test_disturbances_of_another_form_are_refused(text: str, refused: Refused) -> None:
    said = refused("compare", "backends", "-r", 2, "--disturbed", text, code=2)
    assert said == (
        f"--disturbed is {text!r}; it must be a share 0..0.5 and seconds, such as 0.05:60"
    )


def test_a_robot_that_fails_stops_forever() -> None:
    assert parse_disturbed("0:inf") == (0.0, inf)
