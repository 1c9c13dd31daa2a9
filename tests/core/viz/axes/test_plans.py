"""Plans ahead of robots, and arrows from those who push to those who are pushed."""

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from helpers.fleets import fleet_episode
from helpers.pictures import replay_of, short_episode
from matplotlib.collections import LineCollection

from warehouse_core.records.plans import NO_PLANS, StepPlans
from warehouse_core.render.palette import COLORS
from warehouse_core.viz.axes.plans import FADE_STEPS, PlanView
from warehouse_core.viz.tracks.record_track import track_of_record
from warehouse_core.world.tiles import EMPTY

RED, BLUE = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)
PLACES = np.array([(0.5, 0.5), (1.5, 0.5), (1.5, 1.5)])


def shown(plans: StepPlans) -> PlanView:
    view = PlanView(30.0, 3)
    view.show(plans, PLACES, [RED, BLUE, RED])
    return view


def points(lines: LineCollection) -> list[list[list[float]]]:
    return [segment.tolist() for segment in lines.get_segments()]


def test_the_lines_are_the_cells_of_the_plan_without_its_waits() -> None:
    way = [(0, 1), (0, 2), (0, 2), (1, 2)]
    view = shown(StepPlans({1: way}, {1: [(1, 2), (2, 2)]}))
    assert points(view.ways) == [[[1.5, 0.5], [2.5, 0.5]], [[2.5, 0.5], [2.5, 1.5]]]
    assert points(view.wishes) == [[[2.5, 1.5], [2.5, 2.5]]]
    assert not points(shown(NO_PLANS).ways)


def test_lines_have_the_colour_of_their_robot_and_fade_with_time() -> None:
    way = [(0, col) for col in range(FADE_STEPS + 9)]
    view = shown(StepPlans({1: way[:3], 2: [(1, 1)]}, {1: way[2:], 2: [(1, 1), (1, 2)]}))
    colors: Any = view.ways.get_colors().tolist() + view.wishes.get_colors().tolist()[:-1]
    floor = COLORS[EMPTY]
    assert colors[0][:3] == list(BLUE)
    far = [np.abs(np.array(color[:3]) - floor).sum() for color in colors]
    assert all(before > after for before, after in pairwise(far[: FADE_STEPS + 1]))
    assert far[FADE_STEPS] == pytest.approx(far[-1])
    assert far[-1] > 0.2
    assert view.wishes.get_colors()[-1][:3].tolist() == list(RED)


def test_lines_are_below_robots_and_arrows_above_what_is_above_robots() -> None:
    view = shown(NO_PLANS)  # robots have 3, and orders that wait 4
    assert view.ways.get_zorder() == view.wishes.get_zorder() == 2.5
    assert view.pushes.get_zorder() > 4


@pytest.mark.parametrize(("pushed", "pusher"), [(1, 0), (0, 1), (2, 1), (1, 2)])
def test_arrows_go_from_who_pushes_to_who_is_pushed(pushed: int, pusher: int) -> None:
    [path] = shown(StepPlans(pushers={pushed: pusher})).pushes.get_paths()
    ahead = PLACES[pushed] - PLACES[pusher]
    along = (path.vertices[:-1] - (PLACES[pusher] + PLACES[pushed]) / 2) @ ahead
    aside = (path.vertices[:-1] - PLACES[pusher]) @ ahead[::-1]
    assert (along == along.max()).sum() == 1, "the tip is one corner"
    assert (np.isclose(along, along.min())).sum() == 2, "the tail has two"
    assert np.ptp(aside) < np.ptp(along)
    assert along.max() == pytest.approx(-along.min())


def test_each_frame_has_the_plans_of_its_step() -> None:
    episode = fleet_episode(max_steps=6)
    plans = [StepPlans({0: [(1, 1 + step)]}) for step in range(4)]
    frames = track_of_record(episode, plans=plans).frames
    assert [frame.fleet.plans for frame in frames if frame.fleet] == [*plans, *[NO_PLANS] * 3]


def test_a_replay_draws_and_explains_the_plans_of_a_fleet_only() -> None:
    episode, signs = fleet_episode(max_steps=3), {"plan", "shortest way on", "pushes"}
    plans = [NO_PLANS, StepPlans({0: [(1, 1), (1, 2)]}, {0: [(1, 2), (1, 3)]}, {1: 0})]

    def words(given: list[StepPlans]) -> set[str]:
        [legend] = replay_of(episode, plans=given).figure.legends
        return {text.get_text() for text in legend.get_texts()}

    assert words(plans) - words([]) == signs
    assert words([StepPlans(pushers={1: 0})]) - words([]) == {"pushes"}
    replay = replay_of(episode, plans=plans)
    before = np.asarray(replay.figure.pixels())
    replay.go_to(1)
    collections = [
        each for each in replay.figure.axes[0].collections if isinstance(each, LineCollection)
    ]
    assert [[1.5, 1.5], [2.5, 1.5]] in [one for each in collections for one in points(each)]
    assert not np.array_equal(before, np.asarray(replay.figure.pixels()))
    with pytest.raises(TypeError, match="plans are for the record of a fleet"):
        replay_of(short_episode(), plans=plans)
    with pytest.raises(ValueError, match="there is no robot 9"):
        replay_of(episode, plans=[StepPlans({9: []})])
