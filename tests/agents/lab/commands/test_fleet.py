"""The command ``warehouse fleet``."""

import csv
import re
from functools import partial
from math import nan
from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import Warehouse, write_mine
from PIL import Image

from agents.fleet.optimum import Optimum
from agents.lab.commands.fleet import fleet as module
from agents.lab.commands.fleet.report import LINES, diagnosis, share_of_possible, verdict
from agents.lab.commands.fleet.report import measures_table as table
from agents.registry import make_fleet_agent
from warehouse_core import FleetEpisode, Order, OrderStream
from warehouse_core.fleet import Battery, FleetMeasures
from warehouse_core.orders import save_orders
from warehouse_core.records.failure_modes import Diagnosis, diagnose

SMALL = ("fleet", "--robots", 3, "--max-steps", 60, "--seed", 5)


def measured(**changed: float) -> FleetMeasures:
    values: dict[str, float] = {
        "steps": 100, "seconds": 100.0, "orders": 20, "delivered": 18, "per_hour": 648.0,
        "mean_lateness": 2.5, "worst_lateness": 12.0, "on_time": 0.5, "joules": 9000.0,
        "joules_per_delivery": 500.0, "blocked_by_wall": 0, "blocked_by_robot": 10,
        "blocked_by_person": 0, "waits": 30, "charging": 20, "distance": 190, "stranded": 0,
    }  # fmt: skip
    return FleetMeasures(**(values | changed))  # type: ignore[arg-type]


def test_a_shift_is_run_measured_and_recorded(warehouse: Warehouse, monkeypatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    code, out, err = warehouse(*SMALL, "--order-rate", 0.2, "--save", "shift.npz")
    assert (code, err) == (0, "")
    assert max(map(len, out.splitlines())) <= 80
    assert out.startswith("--planner auto chose windowed: 3 robots, 0.0")
    assert "3 robots (auto) on layout depot, backend grid, seed 5" in out
    episode = FleetEpisode.load("shift.npz")
    assert (episode.robots, episode.steps, episode.seed) == (3, 60, 5)
    assert episode.settings.battery == Battery(400)
    rows = [row.split("\u2502") for row in out.splitlines() if row.startswith("\u2502")]
    shown_of = {cells[1].strip(): cells[2].strip().replace(",", "") for cells in rows}
    for line in LINES:
        value = getattr(episode.measures, line.name) * line.factor
        shown = shown_of[line.title]
        expected = "-" if line.of_bodies else "none" if np.isnan(value) else value
        assert shown == expected or float(shown) == pytest.approx(value, rel=0.005), line.title
    assert f"{episode.measures.delivered} of {episode.measures.orders} orders delivered" in out
    assert f"Diagnosis: {diagnose(episode).mode}: " in out
    again = warehouse("replay", "shift.npz", "--save", "shift.png")
    assert again.out.splitlines()[1:-1] == out.splitlines()[2:-1]
    with Image.open("shift.png") as picture:
        assert picture.width > 100


def test_the_options_are_the_settings_of_the_fleet(warehouse: Warehouse) -> None:
    options = (
        "--order-rate", 0.3, "--people", 2, "--battery", "9000joules", "--layout", "hall",
        "--backend", "physics", "--agent", "bfs",
    )  # fmt: skip
    warehouse(*SMALL, *options, "--save", "shift.npz")
    episode = FleetEpisode.load("shift.npz")
    settings = episode.settings
    assert settings.orders == (OrderStream(0.3, (50, 150)),)
    assert settings.people.count == 2
    assert settings.battery == Battery(9000, "joules")
    assert (episode.backend, episode.agent, episode.layout.height) == ("physics", "bfs", 9)


def test_orders_come_from_a_file(warehouse: Warehouse) -> None:
    save_orders("orders.csv", [Order(0, 90, (2, 5), (11, 5)), Order(3, 90, (2, 5), (11, 12))])
    done = warehouse(*SMALL, "--orders", "orders.csv", "--save", "shift.npz")
    assert done.code == 0
    assert [order.due for order in FleetEpisode.load("shift.npz").orders] == [90, 90]


def test_shifts_are_compared_with_what_was_possible(warehouse: Warehouse) -> None:
    save_orders("orders.csv", [Order(0, 60, (2, 5), (11, 5)), Order(0, 9, (2, 5), (11, 5))])
    teams = "--agent", "greedy"
    done = warehouse(*SMALL, *teams, "-n", 2, "--orders", "orders.csv", "--optimum")
    assert done.code == 0
    told = " ".join(done.out.split())
    assert "could deliver 4, and 2 on time. This fleet delivered 25% and 50% of these" in told
    many = [(Optimum(5, True), Optimum(4, True)), (Optimum(15, False), Optimum(0, True))]
    told = share_of_possible([measured(delivered=8), measured(delivered=2)], many)
    assert "at most 20, and 4 on time. This fleet delivered 50% and 125% of these" in told
    assert "Robots that never" not in warehouse(*SMALL).out


def test_orders_and_measures_of_all_shifts_are_written_as_tables(warehouse: Warehouse) -> None:
    out = warehouse(*SMALL, "-n", 2, "--order-rate", 0.3, "-o", "a.csv", "-o", "a.npz").out
    assert "saved a.csv and a-measures.csv" in out
    orders, measures = (
        list(csv.DictReader(Path(name).read_text(encoding="utf-8").splitlines()))
        for name in ("a.csv", "a-measures.csv")
    )
    episode = FleetEpisode.load("a.npz")
    mine = [row for row in orders if row["seed"] == "5"]
    assert [int(row["order"]) for row in mine] == [*range(len(episode.orders))]
    for row, order in zip(mine, episode.orders, strict=True):
        cells = *order.pickup, *order.dropoff
        fate = order.robot, order.taken_by, order.taken, order.delivered
        values = [order.released, order.due, *cells, *fate]
        assert [*row.values()][2:-1] == ["" if each is None else str(each) for each in values]
    late = [int(row["steps_late"]) for row in mine if row["delivered"]]
    assert [row["delivered"] == "" for row in mine] == [row["steps_late"] == "" for row in mine]
    assert [row["seed"] for row in measures] == ["5", "6"]
    first = measures[0]
    assert float(first["mean lateness (steps)"]) == pytest.approx(sum(late) / len(late))
    assert first["distance (cells)"] == str(episode.measures.distance)
    assert first["energy per delivery (kJ)"] == first["simulated time (s)"] == ""  # on the grid
    assert float(first["on time (% of deliveries)"]) == 100 * episode.measures.on_time
    assert first["diagnosis"] == diagnose(episode).mode
    printed = {row.split("\u2502")[1].strip() for row in out.splitlines() if "\u2502" in row}
    titles = {title.rsplit(" (", 1)[0] for title in [*first][1:-2]}
    assert titles == printed - {"measure"} == {line.title for line in LINES}


def test_means_leave_out_what_was_not_measured_and_have_intervals_of_many() -> None:
    two = dict(row[:2] for row in table([measured(), measured(mean_lateness=nan)], "").rows)
    assert two["mean lateness"] == "2.50"
    assert dict(row[:2] for row in table([measured(on_time=nan)], "").rows)["on time"] == "none"
    many = table([measured(waits=number) for number in range(40)], "")
    waits = dict(row[:2] for row in many.rows)["waits"]
    assert re.fullmatch(r"19\.5 \(1\d\.\d to 2\d\.\d\)", waits)
    assert (many.header[1], many.caption) == ("mean (95% interval)", "")


def test_the_verdict_and_the_diagnosis_say_what_went_wrong() -> None:
    why = [Diagnosis(mode, (), 0, None, "why") for mode in ("late", "stranded", "late")]
    assert (diagnosis(why[:1]), diagnosis(why)) == ("late: why", "late (2), stranded (1)")
    assert verdict([measured()], 8) == (
        "18 of 20 orders delivered, 50% of them on time; robots blocked each other in 5% of their "
        "moves; no robot ran out of battery or failed."
    )
    assert "faster than this fleet delivers" not in verdict([measured(orders=34)], 8)
    assert "faster than this fleet delivers" in verdict([measured(orders=35)], 8)
    assert "1 robot ran out of battery or failed. More chargers" in verdict(
        [measured(orders=35, stranded=1)], 8
    )
    nothing = measured(orders=1, delivered=0, on_time=nan, blocked_by_robot=0)
    assert verdict([nothing], 8) == "0 of 1 order delivered; no robot ran out of battery or failed."
    half = [measured(delivered=2, on_time=1.0), measured(delivered=0, on_time=nan)]
    assert "2 of 40 orders delivered, 100% of them on time" in verdict(half, 20)


def test_the_replay_draws_the_plans_of_chosen_robots(warehouse: Warehouse) -> None:
    options = (*SMALL, "--order-rate", 0.2, "--planner", "pibt", "-n", 2)
    pictures = []
    for more in ([], ["--show-plans", "0,2"], ["--show-plans", "pushes"]):
        assert warehouse(*options, *more, "--save", "a.svg").code == 0
        pictures.append(Path("a.svg").read_text())
    assert ['class="plan' in picture for picture in pictures] == [False, True, False]


def test_a_plan_that_takes_too_long_is_cut_off_and_reported(warehouse, monkeypatch) -> None:
    monkeypatch.setattr(module, "make_fleet_agent", partial(make_fleet_agent, seconds=0.02))
    write_mine("next_cells", "while True: pass", "seen.cells", step=1)
    done = warehouse(*SMALL, "--max-steps", 2, "--planner", "mine.py:Mine", "--save", "a.npz")
    assert done.code == 0
    assert done.err == (
        "warehouse: warning: seed 5, step 1, planner mine.py:Mine: the plan took more than "
        "0.02 s; all robots waited; 1 more step lost\n"
    )


def test_robots_with_headings_need_a_planner_that_knows_them(warehouse: Warehouse) -> None:
    turning = (*SMALL, "--moves", "turn")
    done = warehouse(*turning, "--planner", "windowed", "--order-rate", 0.2, "--save", "a.npz")
    assert (done.code, done.err) == (0, "")
    episode = FleetEpisode.load("a.npz")
    assert episode.measures.blocked_by_robot == 0
    assert {1, 2} < {*episode.actions.ravel().tolist()}
    assert warehouse(*turning, "--save", "b.npz").err == ""
    Path("b.npz").unlink()
    assert warehouse(*turning, "--agent", "greedy").err == (
        "warehouse: --moves turn needs a planner; leave out --agent\n"
    )
    for episodes in (1, 2):
        saved = "--save", "b.npz", "--save", "b.csv", "-n", episodes
        done = warehouse(*turning, "--planner", "pibt", *saved)
        assert (done.code, done.out) == (1, "")
        assert done.err.startswith("warehouse: planner PIBT does not support headings")
        assert not [*Path().glob("b*")]


def test_an_interrupt_ends_the_shift_and_prints_the_measures(warehouse: Warehouse) -> None:
    write_mine("act", "raise KeyboardInterrupt", "['N'] * 3")
    done = warehouse(*SMALL, "--planner", "mine.py:Mine", "--save", "a.npz")
    assert done.code == 130
    assert "3 robots (mine.py:Mine)" in done.out
    assert done.err.startswith("warehouse: interrupted in step 4, agent mine.py:Mine")
    assert FleetEpisode.load("a.npz").steps == 3


def test_a_fleet_that_will_run_empty_is_warned_of_once(warehouse: Warehouse) -> None:
    done = warehouse(*SMALL, "-n", 2, "--battery", 20, "--layout", "hall", "--no-show")
    assert done.err.startswith(
        "warehouse: warning: 0 chargers can keep 0 of 3 robots running, and a full battery lasts "
        "20 of 60 steps: robots will run out of battery and block others"
    )
    assert done.err.count("\n") == 1
    hint = "6 robots ran out of battery or failed. More chargers or a larger --battery would help."
    assert hint in " ".join(done.out.split())
