"""The replay of the world beside the belief of the exploring agent."""

from typing import Any

import pytest

from agents.search.agents import ExploringAgent
from agents.search.belief_replay import Insight, belief_tracks, believed_tiles, noted
from warehouse_core import Episode, Layout, WarehouseEnv, record_episode

DETOUR = Layout(["#########", "#.......#", "#.#####.#", "#P....#D#", "#.....#.#", "#########"])


WORDS = {"N": "North", "S": "South", "E": "East", "W": "West", "PICK": "Pick up", "DROP": "Drop"}


def explored(
    layout: Layout = DETOUR, randomize: bool = False, **options: Any
) -> tuple[Episode, list[Insight]]:
    options.setdefault("view_radius", 1)
    start = (3, 3) if layout is DETOUR else layout.default_start()
    return recorded(WarehouseEnv(layout, start, **options), randomize=randomize)


def recorded(env: WarehouseEnv, randomize: bool = True) -> tuple[Episode, list[Insight]]:
    agent = ExploringAgent()
    history = noted(agent, env.layout)
    return record_episode(env, agent, seed=3, randomize=randomize), history


# Recorded beliefs.


# Tiles of the belief.


@pytest.mark.parametrize(
    ("rows", "start", "tiles", "seen"),
    [
        (DETOUR.rows, (3, 3), "????????? ????????? ??###???? ?P...??D? ??...???? ?????????", 9),
        # Row -1 is outside the grid; as an index it would be the last row.
        (["P....", ".....", "....D"], (0, 0), "P.??? ..??? ????D", 4),
        (["PC..C", ".....", "C...D"], (0, 0), "PC??? ..??? ????D", 4),
        # Observations name the first station of each kind.
        (["########", "#P....P#", "#D....D#", "########"], (1, 1),
         "###????? #P.????? #D.????? ????????", 9),
    ],
)  # fmt: skip
def test_at_first_only_the_view_and_two_stations_are_known(rows, start, tiles, seen) -> None:
    env = WarehouseEnv(rows, start, view_radius=1)
    _, history = recorded(env, randomize=False)
    assert believed_tiles(env.layout, history)[0] == tuple(tiles.split())
    assert sum(cell[0] >= 0 <= cell[1] for cell in history[0].seen) == seen


# Tracks and pictures.


@pytest.mark.parametrize("backend", ["grid", "physics"])
def test_each_frame_shows_the_belief_and_the_reason_of_its_move(backend: str) -> None:
    episode, history = explored(backend=backend)
    belief, _ = belief_tracks(episode, history)
    tiles = believed_tiles(DETOUR, history)
    for index, frame in enumerate(belief.frames[:-1]):
        step = belief.step_at(index)
        seen = sum(len(insight.seen) for insight in history[: step + 1])
        assert frame.tiles == tiles[step]
        assert frame.caption == (
            f"{WORDS[episode.actions[step]]}: {episode.reasons[step]} ({seen} cells seen)"
        )
    captions = [frame.caption for frame in belief.frames]
    assert captions[-1].startswith("delivered in")
    assert "North: meets a wall, plans around it (" in "".join(captions)


def test_the_history_of_another_episode_is_an_error() -> None:
    episode, history = explored()
    with pytest.raises(ValueError, match=r"^history has 2 insights for \d+ steps$"):
        belief_tracks(episode, history[:2])
