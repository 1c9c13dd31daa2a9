"""The replay of the world beside the belief of the exploring agent."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.text import Text
from numpy.typing import NDArray
from PIL import Image

from agents.search.agents import ExploringAgent
from agents.search.belief_replay import (
    Insight,
    belief_tracks,
    believed_tiles,
    record_beliefs,
)
from warehouse_core import DEFAULT_LAYOUT, Episode, Layout, WarehouseEnv, record_episode
from warehouse_core.render.palette import INK, UNKNOWN
from warehouse_core.viz.replay import Replay, replay_of_track
from warehouse_core.viz.tracks.episode_track import track_of_episode

DETOUR = Layout(["#########", "#.......#", "#.#####.#", "#P....#D#", "#.....#.#", "#########"])


def explored(
    layout: Layout = DETOUR, randomize: bool = False, **options: Any
) -> tuple[Episode, list[Insight]]:
    options.setdefault("view_radius", 1)
    start = (3, 3) if layout is DETOUR else layout.usual_start()
    env = WarehouseEnv(layout, start, **options)
    return record_beliefs(env, ExploringAgent(), seed=3, randomize=randomize)


def replay(**options: Any) -> Replay:
    return replay_of_track(*belief_tracks(*explored(**options)), window=False)


def unknown_share(image: NDArray[np.int64]) -> tuple[float, float]:
    """Return the share of pixels near ``UNKNOWN`` in the left third and in the middle one."""
    near = np.all(np.abs(image - 255 * np.array(UNKNOWN)) < 10, axis=-1)
    third = image.shape[1] // 3
    return float(near[:, :third].mean()), float(near[:, third : 2 * third].mean())


# Recorded beliefs.


def test_recording_beliefs_does_not_change_the_episode() -> None:
    env, again = (WarehouseEnv(DETOUR, (3, 3), view_radius=1) for _ in range(2))
    alone = record_episode(env, ExploringAgent(), seed=3)
    watched, history = record_beliefs(again, ExploringAgent(), seed=3)
    assert watched == alone
    assert watched.agent == "ExploringAgent"
    assert set(watched.reasons) > {"is there"}
    assert len(history) == watched.steps


def test_each_cell_of_the_belief_is_in_exactly_one_insight() -> None:
    agent = ExploringAgent()
    env = WarehouseEnv(DETOUR, (3, 3), view_radius=1)
    _, history = record_beliefs(env, agent, seed=3)
    known: dict[Any, str] = {}
    for insight in history:
        assert not known.keys() & insight.seen.keys()
        known |= insight.seen
    assert known == agent.belief.known
    assert len(history[0].seen) == 9
    assert len(history[1].seen) <= 3


def test_a_second_recording_with_the_same_agent_is_equal() -> None:
    agent, env = ExploringAgent(), WarehouseEnv(DETOUR, (3, 3), view_radius=1)
    once, again = (record_beliefs(env, agent, seed=3, randomize=False) for _ in range(2))
    assert once == again


def test_the_route_leads_from_the_robot_to_its_goal() -> None:
    episode, history = explored()
    for cell, loaded, insight in zip(episode.cells, episode.loaded, history, strict=False):
        assert insight.route[0] == cell
        assert insight.route[-1] == ((3, 7) if loaded else (3, 1))
        steps = np.abs(np.diff(insight.route, axis=0)).sum(axis=1)
        assert (steps == 1).all()


# Tiles of the belief.


def test_at_first_only_the_view_and_the_two_stations_are_known() -> None:
    _, history = explored()
    first = believed_tiles(DETOUR, history)[0]
    assert first == ("?????????", "?????????", "??###????", "?P...??D?", "??...????", "?????????")
    assert len(history[0].seen) == 9


def test_seen_tiles_are_correct_and_stay_known() -> None:
    episode, history = explored(DEFAULT_LAYOUT, randomize=True)
    before = "?" * 84
    for rows in believed_tiles(episode.layout, history):
        now = "".join(rows)
        truth = "".join(episode.layout.rows)
        assert all(tile in ("?", real) for tile, real in zip(now, truth, strict=True))
        assert all(new != "?" for old, new in zip(before, now, strict=True) if old != "?")
        before = now


def test_walls_outside_the_grid_are_not_drawn_on_the_opposite_side() -> None:
    """Row -1 is outside the grid; as an index it would be the last row."""
    room = Layout(["P....", ".....", "....D"])
    env = WarehouseEnv(room, (0, 0), view_radius=1)
    _, history = record_beliefs(env, ExploringAgent(), randomize=False)
    assert believed_tiles(room, history)[0] == ("P.???", "..???", "????D")
    assert len(history[0].seen) == 4


def test_chargers_in_view_are_drawn() -> None:
    room = Layout(["PC..C", ".....", "C...D"])
    env = WarehouseEnv(room, (0, 0), view_radius=1)
    _, history = record_beliefs(env, ExploringAgent(), randomize=False)
    assert believed_tiles(room, history)[0] == ("PC???", "..???", "????D")


def test_the_tiles_are_the_same_object_until_a_new_cell_is_seen() -> None:
    _, history = explored(view_radius=9)
    assert len({id(rows) for rows in believed_tiles(DETOUR, history)}) == 1


def test_a_second_station_that_has_not_been_seen_is_unknown() -> None:
    two = Layout(["########", "#P....P#", "#D....D#", "########"])
    _, history = explored(two)
    assert believed_tiles(two, history)[0] == ("###?????", "#P.?????", "#D.?????", "????????")


# Tracks and pictures.


@pytest.mark.parametrize("backend", ["grid", "physics"])
def test_both_tracks_have_the_same_frames(backend: str) -> None:
    episode, history = explored(backend=backend)
    world, belief = belief_tracks(episode, history)
    plain = track_of_episode(episode)
    for one, other, alone in zip(world.frames, belief.frames, plain.frames, strict=True):
        assert one.robots == other.robots == alone.robots
        assert one.progress == other.progress
        assert (one.tiles, one.caption, one.route) == (alone.tiles, "", ())


@pytest.mark.parametrize("backend", ["grid", "physics"])
def test_each_frame_shows_the_belief_and_the_reason_of_its_move(backend: str) -> None:
    episode, history = explored(backend=backend)
    _, belief = belief_tracks(episode, history)
    tiles = believed_tiles(DETOUR, history)
    for index, frame in enumerate(belief.frames[:-1]):
        step = belief.step_at(index)
        seen = sum(len(insight.seen) for insight in history[: step + 1])
        assert frame.tiles == tiles[step]
        assert frame.caption == (
            f"now {episode.actions[step]} ({episode.reasons[step]}), {seen} cells seen"
        )
    captions = [frame.caption for frame in belief.frames]
    assert captions[-1].startswith("delivered in")
    assert "now N (meets a wall, plans round it)" in "".join(captions)


def test_the_plan_begins_at_the_edge_of_the_robot_and_ends_at_its_goal() -> None:
    episode, history = explored(backend="physics")
    _, belief = belief_tracks(episode, history)
    assert belief.frames[-1].route == ()
    for index, frame in enumerate(belief.frames):
        [pose], route = frame.robots, frame.route
        if pose is not None and len(route) > 1:
            assert 0.3 < float(np.hypot(*np.subtract(route[0], pose.at))) < 0.4
            assert route[-1] == (
                (7.5, 3.5) if episode.loaded[belief.step_at(index)] else (1.5, 3.5)
            )
    assert sum(bool(frame.route) for frame in belief.frames) > len(belief) / 2


def test_unknown_cells_are_grey_in_the_belief_only_and_become_fewer() -> None:
    shown = replay()
    shown.go_to(0)
    before = unknown_share(np.asarray(shown.figure.pixels()).astype(np.int64))
    shown.show_end()
    after = unknown_share(np.asarray(shown.figure.pixels()).astype(np.int64))
    assert before[0] < 0.01
    assert before[1] > 0.15
    assert after[1] < before[1] / 2


def test_the_two_grids_are_aligned_and_of_equal_size() -> None:
    """The charts beside one of them need more height than either."""
    shown = replay(backend="physics", max_steps=2)
    grids = [axes for axes in shown.figure.findobj(Axes) if axes.get_aspect() == 1]
    boxes = [axes.get_window_extent() for axes in grids]
    assert len(boxes) == 2
    assert boxes[0].height == pytest.approx(boxes[1].height)
    assert boxes[0].y0 == pytest.approx(boxes[1].y0)
    assert boxes[0].x1 < boxes[1].x0


def test_the_plan_is_drawn_from_the_robot_to_the_goal() -> None:
    shown = replay()
    shown.go_to(0)
    [dots] = [
        line
        for line in shown.figure.findobj(Line2D)
        if line.axes is not None and line.is_dashed() and line.get_color() == INK
    ]
    assert dots.get_xydata()[-1].tolist() == [1.5, 3.5]
    shown.show_end()
    assert len(dots.get_xydata()) == 0


def test_the_legend_explains_the_stripes_and_the_dots() -> None:
    found = [text.get_text() for text in replay().figure.findobj(Text)]
    assert found.count("not seen yet") == found.count("plan") == 1


def test_unknown_cells_are_grey_in_a_gif(tmp_path: Path) -> None:
    replay(max_steps=2).save(tmp_path / "belief.gif")
    with Image.open(tmp_path / "belief.gif") as image:
        left, middle = unknown_share(np.asarray(image.convert("RGB")).astype(np.int64))
    assert left < 0.01
    assert middle > 0.15


def test_the_history_of_another_episode_is_an_error() -> None:
    episode, history = explored()
    with pytest.raises(ValueError, match=r"^history has 2 insights for \d+ steps$"):
        belief_tracks(episode, history[:2])
