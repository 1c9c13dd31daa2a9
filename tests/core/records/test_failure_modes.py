import copy
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents.warehouse_agent_greedy import GreedyAgent
from warehouse_core import Cell, Episode, EpisodeRecorder, Layout, WarehouseEnv, record_episode
from warehouse_core.motion.grid import GridMotion
from warehouse_core.records.failure_modes import MIN_STEPS, MODES, diagnose, fewest_steps
from warehouse_core.world.actions import ACTIONS
from warehouse_physics import Disturbances, RigidBodyMotion

WORDS = {"p": "PICK", "d": "DROP", ".": "WAIT"}

LINE = ["P..D"]
LONG = ["P" + "." * 40 + "D"]
HALL = ["P......", ".......", ".......", "......D"]
RING = [".....", ".###.", ".###.", ".....", "....P", "....D"]
ROUND = "EEEESSSWWWWNNN"
"""One round about the block of ``RING``, from its north-west corner."""


def drive(
    rows: Sequence[str],
    start: Cell,
    actions: str,
    *,
    loaded: bool = False,
    units: int | None = None,
    **settings: Any,
) -> Episode:
    """Carry out actions, a letter each, until the episode ends."""
    env = WarehouseEnv(list(rows), start, **settings)
    env.state.has_item = loaded
    env.state.battery = units or env.max_battery
    recorder = EpisodeRecorder(env)
    for letter in actions:
        if not recorder.ended:
            recorder.step(WORDS.get(letter, letter))
    return recorder.episode


class Missing(GridMotion):
    """Replaces the moves of some steps by ``instead``, with nothing in the way."""

    def __init__(self, steps: Iterable[int], instead: Cell = (0, 0)) -> None:
        super().__init__()
        self.steps, self.instead, self.step = set(steps), instead, -1

    def advance(self, displacements: Sequence[Cell], loaded: Sequence[bool]) -> Any:
        self.step += 1
        return super().advance([self.instead] if self.step in self.steps else displacements, loaded)


CHARGED = ["C" + "." * 30 + "PD"]

EXAMPLES = {
    "delivered": drive(LINE, (0, 0), "pEEEd"),
    "unreachable": drive(["P#.D"], (0, 2), "EW" * 20, max_steps=40),
    "stalled": drive(LINE, (0, 1), "E" * 20, max_steps=20, backend=Missing(range(20))),
    "ineffective": drive(LINE, (0, 1), "N" * 20, max_steps=20),
    "oscillation": drive(HALL, (1, 3), "EW" * 20, max_steps=40),
    "wandering": drive(HALL, (1, 0), "EEEESSWWWWNN" * 2, max_steps=24),
    "battery depleted": drive(LONG, (0, 20), "W" * 15, battery=15),
    "out of time": drive(LONG, (0, 20), "W" * 15, max_steps=15),
    "unfinished": drive(LONG, (0, 20), "W" * 15),
}


@pytest.mark.parametrize("mode", MODES)
def test_every_mode_has_an_example_which_loads_with_it(mode: str, tmp_path: Path) -> None:
    assert tuple(EXAMPLES) == MODES
    found = diagnose(EXAMPLES[mode])
    assert found.mode == mode
    EXAMPLES[mode].save(tmp_path / "episode.npz")
    assert diagnose(Episode.load(tmp_path / "episode.npz")) == found


def check(why: str, episode: Episode, **expected: Any) -> Any:
    """Return a row of the tables below: an episode, and parts of its diagnosis."""
    return pytest.param(episode, expected, id=why)


def missing(
    rows: Sequence[str], start: Cell, actions: str, steps: Iterable[int],
    instead: Cell = (0, 0), **more: Any,
) -> Episode:  # fmt: skip
    """Return an episode in which some steps miss their cell."""
    return drive(rows, start, actions, backend=Missing(steps, instead), **more)


def blocked(rows: Sequence[str], *, loaded: bool = False) -> Episode:
    return drive(rows, (0, 0), "." * 30, loaded=loaded, max_steps=30)


NO_PATH = "no path leads from (0, 0) to the"
MISSED = "steps missed their target cell although nothing blocked them"
PATTERNS = [
    # Delivered.
    check(
        "compared with the shortest path", drive(LINE, (0, 0), "p.EEE.d"), mode="delivered",
        cells=((0, 3),), steps=7, needed=5, robots=(0,),
        sentence="delivered in 7 steps; the minimum is 5",
    ),
    check(
        "with the last unit", drive(LINE, (0, 0), "pEEEd", battery=5, max_steps=5),
        mode="delivered",
    ),
    check(
        "starts loaded", drive(["..D"], (0, 0), "EEd", loaded=True), mode="delivered",
        cells=((0, 2),), steps=3, needed=3,
    ),
    # Unreachable.
    *(
        check(
            f"{rows} {loaded}", blocked(rows, loaded=loaded), mode="unreachable", cells=cells,
            steps=30, needed=None, sentence=sentence,
        )
        for rows, loaded, cells, sentence in (
            (["...."], False, (), "there is no pickup"),
            (["D..."], False, (), "there is no pickup"),
            (["P..."], False, (), "there is no dropoff"),
            (["P..."], True, (), "there is no dropoff"),
            ([".D#P"], False, ((0, 3),), f"{NO_PATH} pickup at (0, 3)"),
            ([".P#D"], False, ((0, 3),), f"{NO_PATH} dropoff at (0, 3)"),
            ([".P#D"], True, ((0, 3),), f"{NO_PATH} dropoff at (0, 3)"),
            ([".#PD"], False, ((0, 2),), f"{NO_PATH} pickup at (0, 2)"),
            ([".#PD"], True, ((0, 3),), f"{NO_PATH} dropoff at (0, 3)"),
            ([".#PP", ".#PD"], False, ((0, 2), (0, 3), (1, 2)),
             f"{NO_PATH} pickup at (0, 2), (0, 3) or (1, 2)"),
        )
    ),
    *(
        check(f"reachable {rows}", drive(rows, (0, 0), "", loaded=loaded), mode="unfinished")
        for rows, loaded in (
            ([".D#P"], True), ([".PD#P"], False), ([".PD#D"], False), ([".PD#PD"], False),
        )
    ),
    # Stalled.
    check(
        "mostly misses", missing(LONG, (0, 20), "W" * 20, range(2, 20), max_steps=20),
        mode="stalled", cells=((0, 18),), steps=18, needed=63,
        sentence=f"18 of 20 {MISSED}, 18 of them from (0, 18)",
    ),
    check(
        "cell of most misses",
        missing(LONG, (0, 20), "W" * 18, [0, 1, 2, *range(4, 12), *range(14, 18)]),
        mode="stalled", cells=((0, 19),), steps=15,
        sentence=f"15 of 18 {MISSED}, 8 of them from (0, 19)",
    ),
    check("7 misses", missing(LONG, (0, 40), "W" * 20, range(7)), mode="unfinished"),
    check("8 misses", missing(LONG, (0, 40), "W" * 20, range(8)), mode="stalled"),
    check(
        "12 of 30 lost", missing(LONG, (0, 40), "W" * 12 + "N" * 18, range(12)), mode="stalled"
    ),
    check(
        "12 of 31 lost", missing(LONG, (0, 40), "W" * 12 + "N" * 19, range(12)),
        mode="ineffective",
    ),
    # Ineffective.
    *(
        check(
            f"{waits} of 20 without effect",
            drive(
                HALL, (1, 0),
                "".join(f"{move}." for move in "EEEESSWWWW"[:waits]) + "EEEESSWWWW"[waits:],
            ),
            mode=mode,
        )
        for waits, mode in ((9, "wandering"), (10, "ineffective"))
    ),
    # Oscillation.
    *(
        check(
            actions, drive(HALL, (1, 3), actions), mode="oscillation", cells=cells, steps=steps,
            sentence=f"{what} for the last {steps} steps",
        )
        for actions, cells, what, steps in (
            ("EW" * 20, ((1, 3), (1, 4)), "kept moving between (1, 3) and (1, 4)", 40),
            ("EWWE" * 10, ((1, 3), (1, 4), (1, 2)),
             "kept moving between (1, 3), (1, 4) and (1, 2)", 40),
            ("ESWN" * 10, ((1, 3), (1, 4), (2, 4), (2, 3)),
             "kept moving between (1, 3), (1, 4), (2, 4) and (2, 3)", 40),
            (".NS" * 9, ((1, 3), (0, 3)), "kept moving between (1, 3) and (0, 3)", 27),
            ("WWE" + "NS" * 9, ((1, 2), (0, 2)), "kept moving between (1, 2) and (0, 2)", 18),
            ("WNSE" * 5 + "." * 18, ((1, 3),), "stayed in (1, 3)", 18),
        )
    ),
    check(
        "fewer cells, too short", drive(HALL, (1, 3), "ESWN" * 20 + "EW" * 5),
        cells=((1, 3), (1, 4), (2, 4), (2, 3)), steps=90,
    ),
    check(
        "ends with the item", drive(["DP..."], (0, 1), "EW" * 6 + "p" + "EW" * 6, max_steps=25),
        mode="oscillation", steps=12,
    ),
    # The last step of the path to it belongs to it.
    check("7 steps", drive(LONG, (0, 40), "W" * 20 + "EWEWEW"), mode="unfinished"),
    check("8 in any order", drive(LONG, (0, 40), "W" * 20 + "EWWEEWE"), mode="oscillation"),
    check("8 steps", drive(LONG, (0, 40), "W" * 20 + "EWEWEWE"), mode="oscillation"),
    check("15 of 39", drive(HALL, (1, 0), "EEEESSWWWWNN" * 2 + "W" * 15), mode="wandering"),
    check("16 of 40", drive(HALL, (1, 0), "EEEESSWWWWNN" * 2 + "W" * 16), mode="oscillation"),
    *(
        check(
            f"{cells} cells",
            drive(
                HALL, (1, 0),
                "".join("E" * (cells - 2) + "WE" * k + "E" + "W" * (cells - 1)
                        for k in range(1, 5)),
            ),
            mode=mode,
        )
        for cells, mode in ((4, "oscillation"), (5, "wandering"))
    ),
    check("three rounds", drive(RING, (0, 0), (ROUND * 3)[:-1]), mode="oscillation"),
    check("not quite three rounds", drive(RING, (0, 0), (ROUND * 3)[:-2]), mode="wandering"),
    check(
        "a loop", drive(RING, (0, 0), "E.N" + ROUND[1:] + ROUND * 4), mode="oscillation", steps=72,
        sentence="repeated a loop of 14 cells through (0, 0) for the last 72 steps",
    ),
    *(
        check(
            f"a loop and {more}", drive(HALL, (1, 3), ("WEWEESWN" * 6)[: 40 + more]),
            mode="oscillation", steps=40 + more,
        )
        for more in range(8)
    ),
    # Wandering.
    check(
        "no progress", drive(HALL, (1, 0), "EEEESSWWWWNN" * 2), mode="wandering",
        cells=((1, 0),), steps=24, needed=12,
        sentence="24 moves over 12 cells without getting closer to the delivery",
    ),
    check(
        "half of the moves lost", drive(LONG, (0, 40), "WWE" * 13 + "W" * 13), mode="wandering",
        steps=26,
        sentence="52 moves over 27 cells brought it only 26 steps closer to the delivery",
    ),
    check("26 of 53 lost", drive(LONG, (0, 40), "WWE" * 13 + "W" * 14), mode="unfinished"),
    check("7 moves", drive(HALL, (1, 0), "EESSWWN"), mode="unfinished"),
    check("8 moves", drive(HALL, (1, 0), "EESSWWNN"), mode="wandering"),
    *(
        check(
            f"{mode} with misses", missing(HALL, (1, 0), "WW" + actions, range(2)), mode=mode,
            sentence=f"{sentence}; 2 steps missed their target cell",
        )
        for mode, actions, sentence in (
            ("oscillation", "EW" * 6,
             "kept moving between (1, 0) and (1, 1) for the last 14 steps"),
            ("wandering", "EEESSWWWNN" * 2,
             "20 moves over 10 cells without getting closer to the delivery"),
        )
    ),
    # Budgets.
    *(
        check(
            f"{mode} {limits}", drive(LONG, (0, 20), "W" * 15, **limits), mode=mode,
            cells=((0, 5),), steps=48, needed=63,
            sentence=f"{ending} 48 steps short of the delivery; the minimum is 63",
        )
        for limits, mode, ending in (
            ({"battery": 15}, "battery depleted", "the battery ran out"),
            ({"max_steps": 15}, "out of time", "the time ran out"),
            ({"battery": 15, "max_steps": 15}, "battery depleted", "the battery ran out"),
            ({}, "unfinished", "the episode was stopped"),
        )
    ),
    check(
        "no step", drive(LINE, (0, 1), ""), mode="unfinished", cells=((0, 1),), steps=6, needed=6
    ),
    # Charging.
    check(
        "charging is not lost",
        drive(CHARGED, (0, 0), "." * 25 + "E" * 10, units=5, battery=300, max_steps=35),
        mode="out of time", steps=24,
    ),
    check(
        "a full battery", drive(CHARGED, (0, 0), "." * 25, units=15, battery=20, max_steps=25),
        mode="ineffective", steps=24, sentence="24 waits: at (0, 0)",
    ),
    check(
        "charging at the end",
        drive(CHARGED, (0, 12), "W" * 12 + "." * 20, units=20, battery=300, max_steps=32),
        mode="wandering", steps=12,
    ),
]  # fmt: skip


@pytest.mark.parametrize(("episode", "expected"), PATTERNS)
def test_the_pattern_of_an_episode_is_named(episode: Episode, expected: dict[str, Any]) -> None:
    found = diagnose(episode)._asdict()
    assert {name: found[name] for name in expected} == expected
    if found["mode"] == "oscillation":
        assert len(set(found["cells"])) == len(found["cells"])


def test_a_robot_moved_by_hand_to_a_closed_cell_cannot_reach_the_stations() -> None:
    env = WarehouseEnv(["PD#."], (0, 0))
    recorder = EpisodeRecorder(env)
    env.state.robot_pos = (0, 3)
    recorder.step("WAIT")
    assert diagnose(recorder.episode).mode == "unreachable"


def test_a_robot_moved_by_hand_to_the_stations_has_made_no_progress() -> None:
    env = WarehouseEnv(["PD#."], (0, 3))
    recorder = EpisodeRecorder(env)
    env.state.robot_pos = (0, 0)
    recorder.step("WAIT")
    sentence = "the episode was stopped 3 steps short of the delivery"
    assert diagnose(recorder.episode)[:5] == ("unfinished", ((0, 0),), 3, None, sentence)
    for _ in range(MIN_STEPS):
        recorder.step("WAIT")
    assert diagnose(recorder.episode).mode == "ineffective"


@pytest.mark.parametrize(
    ("disturbances", "cell"),
    [
        (Disturbances(motor_strength=0.0), (0, 9)),
        (Disturbances(slippery=frozenset({(0, 6)}), grip=0.0), (0, 6)),
    ],
    ids=["no motor", "ice"],
)
def test_a_robot_without_force_or_grip_is_stalled(disturbances: Disturbances, cell: Cell) -> None:
    backend = RigidBodyMotion(disturbances=disturbances)
    env = WarehouseEnv(["P.........D"], (0, 9), max_steps=40, backend=backend)
    found = diagnose(record_episode(env, GreedyAgent(seed=0), seed=0, randomize=False))
    assert (found.mode, found.cells) == ("stalled", (cell,))


@pytest.mark.parametrize(
    ("actions", "sentence"),
    [
        (["north"] * 20, "20 unknown actions: 'north'"),
        ([99] * 15 + ["fly"] * 5, "20 unknown actions, 15 of them 99"),
        (["PICK"] * 20, "20 useless picks: at (1, 3)"),
        (["drop"] * 20, "20 useless drops: at (1, 3)"),
        (["WAIT"] * 20, "20 waits: at (1, 3)"),
        (["N"] * 20, "19 bumps: at (0, 3)"),
        (["E"] + ["WAIT", "N"] * 10, "10 waits and 9 bumps"),
        (["WAIT"] * 3 + ["E"] + ["WAIT"] * 9, "12 waits, 9 of them at (1, 4)"),
        (["up"] * 12 + ["WAIT"] * 12, "12 unknown actions: 'up'"),
        (["x" * 99] * 20, f"20 unknown actions: '{'x' * 12}...{'x' * 13}'"),
    ],
)
def test_steps_without_effect_are_counted_by_kind(actions: list[Any], sentence: str) -> None:
    recorder = EpisodeRecorder(WarehouseEnv(HALL, (1, 3)))
    for action in actions:
        recorder.step(action)
    found = diagnose(recorder.episode)
    assert (found.mode, found.sentence) == ("ineffective", sentence)
    assert found.steps == sum(
        int(word) for word in sentence.split(",")[0].split() if word.isdigit()
    )


# The fewest steps.


def fewest_by_search(layout: Layout, cell: Cell, loaded: bool) -> int | None:
    """Search all states by steps of an environment, until an action delivers."""
    env = WarehouseEnv(layout, cell, max_steps=10**9, battery=10**9)
    known, states, steps = {(cell, loaded)}, [(cell, loaded)], 0
    while states:
        steps += 1
        ahead = []
        for state in states:
            for action in range(len(ACTIONS)):
                env.state.robot_pos, env.state.has_item = state
                if env.advance(action)[1]:
                    return steps
                after = (env.state.robot_pos, env.state.has_item)
                if after not in known:
                    known.add(after)
                    ahead.append(after)
        states = ahead
    return None


LAYOUTS = st.integers(1, 5).flatmap(
    lambda width: st.lists(
        st.text("...##PDC", min_size=width, max_size=width), min_size=1, max_size=4
    )
).filter(lambda rows: any(set(row) != {"#"} for row in rows)).map(Layout)  # fmt: skip


@settings(max_examples=40)
@given(LAYOUTS, st.data())
def test_the_fewest_steps_equal_those_of_an_exhaustive_search(layout: Layout, data: Any) -> None:
    cells = st.integers(0, len(layout.open_cells) - 1).map(layout.open_cell)
    states = data.draw(st.lists(st.tuples(cells, st.booleans()), min_size=1, max_size=3))
    expected = tuple(fewest_by_search(layout, *state) for state in states)
    assert fewest_steps(layout, *states) == expected


# Any episode.


def test_an_action_may_be_a_word_in_any_case_or_an_index() -> None:
    for example in EXAMPLES.values():
        words = copy.deepcopy(example)
        words.actions = [str(action).lower() for action in example.actions]
        assert diagnose(words) == diagnose(example)
        indices = copy.deepcopy(example)
        indices.actions = [ACTIONS.index(str(action)) for action in example.actions]
        assert diagnose(indices) == diagnose(example)


@pytest.mark.parametrize(
    ("actions", "ending"),
    [
        ("EEEWWW" * 5, "never used PICK: it stood on the pickup 6 times"),
        ("p" + "EEEWWW" * 5, "never used DROP: it stood on the dropoff 5 times"),
        ("." + "EEEWWW" * 5 + "E", "never used PICK: it stood on the pickup 6 times"),
        ("EEEWWW" * 5 + "p" + "EWEW" * 5, "the delivery"),
        ("EEdWWEEWW" * 4, "never used PICK: it stood on the pickup 9 times"),
    ],
)
def test_an_action_that_was_needed_and_never_used_is_named(actions: str, ending: str) -> None:
    """The walker starts on the pickup, and never stops for long."""
    sentence = diagnose(drive(LINE, (0, 0), actions)).sentence
    assert sentence.endswith(ending) or "never used" not in ending, sentence
    assert ("never used" in sentence) == ("never used" in ending)
