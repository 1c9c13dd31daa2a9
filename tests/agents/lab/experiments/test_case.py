"""Cases, which leave out settings without effect, and their keys, which equal cases share."""

from pathlib import Path
from typing import Any

import pytest
from helpers.command_line import write_mine

from agents.errors import AgentError, EpisodeError, ParameterError
from agents.fleet.planned import DEFAULT_ASSIGNMENT
from agents.lab.experiments.case import (
    check_fingerprint,
    flags_of,
    key_of,
    layout_for,
    make_agent_for,
    make_case,
    read_case,
    run_one,
)
from agents.lab.experiments.plan import make_plan
from agents.warehouse_agent_greedy import GreedyAgent
from warehouse_core import DEFAULT_LAYOUT, LayoutError, OrderStream
from warehouse_core.fleet import Battery
from warehouse_core.world.named_layouts import find_layout


@pytest.mark.parametrize(
    ("choices", "needs"),
    [
        ({"density": [0.1, 0.2]}, "density has no effect here; it applies only with layout=random"),
        ({"escape": False, "memory": [2, 5]},
         "memory has no effect here; it applies only with agent=greedy and escape=on"),
        ({"robot.mass": [50, 70]},
         "robot.mass has no effect here; it applies only with backend=physics"),
        ({"robots": 2, "stations": "drawn"}, "stations has no effect here; it applies only to "
         "lone robots, without settings for fleets"),
        ({"robots": 2, "assignment": "fifo"},
         "assignment has no effect here; it applies only with a planner"),
        ({"robots": 100, "layout": "random", "size": "5x5"}, "100 robots and 0 people do not fit "
         "on the 7 open cells of the layout; each needs a cell"),
    ],
)  # fmt: skip
def test_a_choice_without_any_effect_or_room_is_an_error(
    choices: dict[str, Any], needs: str
) -> None:
    with pytest.raises(ParameterError) as caught:
        make_plan(choices, 1, 0)
    assert str(caught.value) == needs


@pytest.mark.parametrize(
    ("choices", "cases"),
    [
        ({"battery": [20, 20]}, 1),
        ({"layout": ["default", "random"], "density": [0.1, 0.2]}, 3),
        ({"escape": [True, False], "memory": [2, 5]}, 3),
        ({"backend": ["grid", "physics"], "robot.mass": [50, 60, 70]}, 4),
        ({"size": ["7x12", "8x8"], "layout": "random"}, 2),
    ],
)
def test_only_values_with_an_effect_add_cases(choices: dict[str, Any], cases: int) -> None:
    assert len(make_plan(choices, 1, 0).cases) == cases


def test_a_user_agent_has_neither_memory_nor_escape_and_its_code_is_part_of_the_case() -> None:
    write_mine("act", "pass", "'WAIT'")
    agents = ["greedy", "mine.py:Mine"]
    choices = {"agent": agents, "escape": [True, False], "memory": [1, 2]}
    *_, case = make_plan(choices, 1, 0).cases
    assert case["agent"] == agents[1]
    assert not {"escape", "memory"} & case.keys()
    assert make_plan(choices, 1, 0).cases[-1] == case
    write_mine("act", "pass", "'N'")
    assert key_of(make_plan(choices, 1, 0).cases[-1]) != key_of(case)


def test_a_changed_layout_file_makes_another_case() -> None:
    rows = [list(row) for row in DEFAULT_LAYOUT.rows]
    keys = []
    for tile in (".", ".", "#"):
        rows[1][1] = tile
        Path("layout.txt").write_text("\n".join(map("".join, rows)) + "\n")
        keys.append(key_of(make_case({"layout": "layout.txt"})))
    assert keys[0] == keys[1] != keys[2]


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("import sys\nsys.exit(0)", "SystemExit: 0 (own.py, line 2)"),
        (
            "class Own:\n    reset = act = print\n    def __init__(self):\n        self.x",
            "AttributeError: 'Own' object has no attribute 'x' (own.py, line 4)",
        ),
    ],
    ids=["a file that exits", "a class that fails"],
)
def test_an_agent_that_cannot_be_made_is_an_error_before_the_sweep(text: str, reason: str) -> None:
    Path("own.py").write_text(text)
    with pytest.raises(ParameterError) as caught:
        make_plan({"agent": "own.py:Own"}, 1, 0)
    what = "agent 'own.py:Own' cannot be made" if "class" in text else "cannot import agent file"
    assert str(caught.value).startswith(what)
    assert str(caught.value).endswith(f": {reason}")


@pytest.mark.parametrize(
    ("rows", "stations"), [("#P...D#", "kept"), ("#.....#", "drawn"), (None, "drawn")]
)
def test_the_stations_of_a_layout_file_are_kept_if_it_has_any(
    rows: str | None, stations: str
) -> None:
    values = {} if rows is None else {"layout": "hall.txt"}
    Path("hall.txt").write_text(rows or "")
    case, other = make_case(values), "drawn" if stations == "kept" else "kept"
    assert case["stations"] == stations
    assert "stations=" not in "".join(flags_of(case))
    if "P" in "".join(case["tiles"]):
        changed = make_case({**values, "stations": other})
        assert flags_of(changed) == [*flags_of(case), f"stations={other}"]
        assert key_of(changed) != key_of(case)


@pytest.mark.parametrize(
    ("rows", "values", "message"),
    [
        ("P..", {}, "there is no dropoff D; add one, or use stations=drawn"),
        ("...", {"stations": "kept"}, "there is no pickup P; add one, or use stations=drawn"),
        ("P.D", {"stations": "drawn"}, "it has 1 empty cell; random stations need two or more"),
    ],
)
def test_a_missing_station_is_an_error_before_the_sweep(
    rows: str, values: dict[str, Any], message: str
) -> None:
    Path("hall.txt").write_text(rows)
    with pytest.raises(ParameterError, match=f"hall.txt: .*{message}"):
        make_plan({"layout": "hall.txt", **values}, 1, 0)


@pytest.mark.parametrize("layout", ["hall.txt", "random", "default"])
@pytest.mark.parametrize("stations", ["kept", "drawn"])
def test_each_episode_keeps_the_stations_or_draws_them(layout: str, stations: str) -> None:
    Path("hall.txt").write_text("##########\n#P......D#\n##########\n")
    case = make_case({"layout": layout, "stations": stations, "max_steps": 3})
    for seed in range(3):
        before = layout_for(case, seed)
        [episode, again] = [run_one(case, seed) for _ in range(2)]
        assert (episode.layout == before) is (stations == "kept")
        assert episode == again
    starts = {run_one(case, seed).cells[0] for seed in range(9)}
    assert len(starts) > 1


def test_a_setting_of_fleets_makes_it_a_fleet_with_the_defaults_of_fleets() -> None:
    case = make_case({"people": 2})
    assert (case["robots"], case["layout"], case["battery"]) == (8, "depot", 400)
    assert case["chargers"] == len(find_layout("depot").chargers)
    assert flags_of(case) == ["people=2"]
    assert read_case(key_of(case)) == case


FLEET_CASE = {"robots": 3, "order_rate": 0.3, "max_steps": 40}


def test_the_settings_of_a_fleet_reach_it() -> None:
    case = make_case({**FLEET_CASE, "due": "3:9", "people": 1, "chargers": 1, "battery": 77})
    episode = run_one(case, 5)
    settings = episode.settings
    assert (settings.robots, settings.max_steps, settings.battery) == (3, 40, Battery(77))
    assert settings.people.count == 1
    assert settings.orders == (OrderStream(0.3, (3, 9)),)
    assert len(episode.layout.chargers) == 1
    assert episode == run_one(case, 5)
    assert episode != run_one(case, 6)


def test_a_fleet_has_the_agents_of_its_case() -> None:
    cases = [make_case({**FLEET_CASE, **agent}) for agent in
             ({}, {"escape": False}, {"memory": 2}, {"agent": "astar"})]  # fmt: skip
    teams = [make_agent_for(case, 0, find_layout("depot")).agents for case in cases]
    assert [len(team) for team in teams] == [3] * 4
    assert [type(team[0]).__name__ for team in teams] == [*["GreedyAgent"] * 3, "SearchAgent"]
    found = [(team[0].memory, team[0].escape_steps) for team in teams[:3]]
    usual = GreedyAgent()
    assert found == [(10, usual.escape_steps), (usual.memory, 0), (2, usual.escape_steps)]


def test_chargers_are_taken_from_all_parts_of_the_layout() -> None:
    chargers = find_layout("depot").chargers
    for count in range(len(chargers) + 1):
        found = layout_for(make_case({"chargers": count}), 0).chargers
        assert len(found) == count
        assert {*found} <= {*chargers}
    two = layout_for(make_case({"chargers": 2}), 0).chargers
    assert two == (chargers[0], chargers[len(chargers) // 2])
    with pytest.raises(LayoutError, match=f"chargers is 99; the layout has {len(chargers)}"):
        make_case({"chargers": 99})


def test_a_planner_replaces_the_agents() -> None:
    write_mine("next_cells", "pass", "seen.cells")
    case = make_case({**FLEET_CASE, "planner": "mine.py:Mine", "agent": "astar"})
    assert not {"agent", "escape", "memory"} & case.keys()
    assert case["assignment"] == DEFAULT_ASSIGNMENT
    assert run_one(case, 0).measures.distance == 0
    write_mine("next_cells", "pass", "[*seen.cells]")
    with pytest.raises(EpisodeError, match=r"mine\.py:Mine', or what it imports, has changed"):
        check_fingerprint(case)
    pibt = [run_one(make_case({**FLEET_CASE, "planner": "pibt", "assignment": name}), 0)
            for name in ("urgent", "fifo")]  # fmt: skip
    assert pibt[0].measures.delivered > 0
    assert pibt[0] != pibt[1]
    assert pibt[0].agent == "pibt"
    assert "assignment" not in make_case(FLEET_CASE)
    with pytest.raises(AgentError, match="no planner is called 'pibbt'"):
        make_case({**FLEET_CASE, "planner": "pibbt"})
