"""Where robots were blocked, and how often something happened in each cell."""

from warehouse_core import FleetEnv, Layout
from warehouse_core.records import FleetEpisode, FleetRecorder
from warehouse_core.viz.axes.heat_map import held_up_cells


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
