import numpy as np
import pytest
from helpers.fleet_truth import EAST, WAIT

from warehouse_core import FleetEnv, Layout, random_layout
from warehouse_core.batch import people
from warehouse_core.batch.fleet_settings import HABITS
from warehouse_core.fleet import People

CORRIDOR = Layout(["....."])

over_habits = pytest.mark.parametrize("habit", HABITS)


def walk(layout: Layout, crowd: People, steps: int, seed: int = 1) -> np.ndarray:
    """Return the cells of people, ``[steps, P, 2]``, while a robot waits in the last open cell."""
    last = layout.open_cell(len(layout.open_cells) - 1)
    fleet = FleetEnv(layout, 1, starts=[last], people=crowd, max_steps=steps, battery=steps)
    fleet.reset(seed=seed)
    cells = [fleet.people]
    for _ in range(steps - 1):
        fleet.step([WAIT])
        cells.append(fleet.people)
    return np.array(cells)


@over_habits
@pytest.mark.parametrize("backend", ["grid", "physics"])
def test_people_are_never_in_a_wall_in_a_robot_or_in_each_other(habit, backend) -> None:
    layout = random_layout(7, 7, 0.25, seed=4)
    steps = 400 if backend == "grid" else 60
    fleet = FleetEnv(
        layout, 6, people=People(5, habit), backend=backend, max_steps=steps, battery=steps
    )
    fleet.reset(seed=2)
    stream, moved = np.random.default_rng(1), 0
    for _ in range(steps):
        before = fleet.people
        _, _, _, _, info = fleet.step(stream.integers(0, 5, 6))
        cells = fleet.cells + fleet.people
        assert len(set(cells)) == 11
        assert all(map(layout.is_open, cells))
        moves = [
            abs(a - c) + abs(b - d) for (a, b), (c, d) in zip(before, fleet.people, strict=True)
        ]
        assert max(moves) <= 1
        moved += sum(moves)
        assert info["motion"]["stopped_by"].shape == (6,)
        assert len(fleet.last_motion) == 11
        assert [outcome.cell for outcome in fleet.last_motion] == cells
    assert moved > steps / 2
    measures = fleet.measures
    assert measures.blocked_by_person > 0
    assert measures.blocked_by_robot > 0
    assert measures.blocked_by_wall > 0


def test_a_robot_that_runs_into_a_person_is_blocked_and_counted() -> None:
    fleet = FleetEnv(["..", "##"], 1, starts=[(0, 0)], people=People(1, pause=1.0))
    fleet.reset(seed=1)
    assert fleet.people == [(0, 1)]
    assert fleet.observe(0)["local_grid"][2] == "##RH#"
    _, rewards, _, _, info = fleet.step([EAST])
    assert (fleet.cells, fleet.people) == ([(0, 0)], [(0, 1)])
    assert info["motion"]["stopped_by"].tolist() == [1]
    assert rewards.tolist() == [-1.1]
    assert (fleet.measures.blocked_by_person, fleet.measures.distance) == (1, 0)


def test_people_walk_from_station_to_station_on_shortest_paths() -> None:
    apart = Layout(["P.....", "######", "D....."])
    open_layout = Layout(["P....D", "......", "......"])
    cells = walk(open_layout, People(1, pause=0.0), 300)[:, 0]
    visits = [step for step, cell in enumerate(cells.tolist()) if cell in ([0, 0], [0, 5])]
    legs = np.diff(visits)
    assert len(visits) > 20
    assert (legs == 5).mean() > 0.8
    # A goal without a path is never reached, but nobody stands still because of it.
    assert (
        np.abs(np.diff(walk(apart, People(1, pause=0.0), 99)[:, 0], axis=0)).sum(1) > 0
    ).mean() > 0.5


@over_habits
def test_people_pause_as_often_as_is_set(habit: str) -> None:
    for pause in (0.0, 0.4, 1.0):
        moves = np.abs(
            np.diff(walk(Layout(["." * 20] * 20), People(3, habit, pause), 600), axis=0)
        ).sum(axis=-1)
        assert (moves == 0).mean() == pytest.approx(pause, abs=0.06)


def test_a_person_in_front_of_a_robot_that_waits_turns_back() -> None:
    cells = walk(Layout(["P...D"]), People(1, pause=0.0), 60)[:, 0, 1]
    assert len(set(cells.tolist())) > 2


def test_people_and_their_goals_are_limited(monkeypatch: pytest.MonkeyPatch) -> None:
    stations = Layout(["PD" * 40, "." * 80])
    assert len(people._goals(stations)) == 27
    monkeypatch.setattr(people, "MAX_GOAL_CELLS", 5 * 160)
    assert len(people._goals(stations)) == 5
    assert len(people._goals(CORRIDOR)) == 5
