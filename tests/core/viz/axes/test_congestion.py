"""Where robots were held up, and the heat maps of several fleets side by side."""

from helpers.fleets import fleet_episode
from matplotlib.figure import Figure

from warehouse_core import FleetEnv, Layout
from warehouse_core.records import FleetEpisode, FleetRecorder
from warehouse_core.viz.axes.congestion import congestion_picture, held_up_cells


def driven(*actions: list[str]) -> FleetEpisode:
    layout, starts = Layout(["...C.", "....."]), [(0, 1), (1, 4)]
    env = FleetEnv(layout, 2, orders=None, starts=starts, max_steps=20)
    recorder = FleetRecorder(env, seed=1)
    for each in actions:
        recorder.step(each)
    return recorder.episode


def test_waiting_being_blocked_and_turning_back_hold_robots_up() -> None:
    # Robot 0 waits, goes east, turns back, goes west; robot 1 is blocked by the border.
    episode = driven(["WAIT", "E"], ["E", "W"], ["W", "W"], ["W", "W"])
    assert held_up_cells(episode).tolist() == [[0, 1, 1, 0, 0], [0, 0, 0, 0, 1]]


def test_charging_and_ways_around_corners_do_not_hold_robots_up() -> None:
    episode = driven(["E", "W"], ["E", "W"], ["WAIT", "N"], ["S", "E"], ["W", "E"])
    assert held_up_cells(episode).sum() == 0
    assert held_up_cells(driven(*[["PICK", "DROP"]] * 3)).sum() == 0


def test_a_wait_between_two_moves_is_counted_once() -> None:
    episode = driven(["E", "W"], ["WAIT", "W"], ["W", "W"])
    assert held_up_cells(episode).tolist() == [[0, 0, 1, 0, 0], [0] * 5]


def test_the_panels_have_one_scale_and_their_deliveries() -> None:
    few, many = fleet_episode(max_steps=20), fleet_episode(max_steps=80)
    highest = max(int(held_up_cells(each).max()) for each in (few, many))
    assert held_up_cells(few).max() < highest
    panels = {"a few": few, "many": many}
    figure = congestion_picture(panels, "two fleets", lambda size: Figure(figsize=size))
    drawn = [each for axes in figure.axes[:2] for each in axes.collections]
    heats = [each for each in drawn if each.get_array() is not None]
    assert [heat.get_clim() for heat in heats] == [(0, highest)] * 2
    assert [int(heat.get_array().sum()) for heat in heats] == [  # type: ignore[union-attr]
        int(held_up_cells(each).sum()) for each in (few, many)
    ]
    said = [text.get_text() for text in figure.texts]
    assert said[:2] == ["two fleets", "a few"]
    for each in (few, many):
        share = held_up_cells(each).sum() / (each.steps * each.robots)
        assert f"{each.measures.per_hour:,.0f} deliveries per hour" in said
        assert f"robots held up in {share:.0%} of their steps" in said
