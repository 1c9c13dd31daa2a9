import copy
from collections.abc import Iterable, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents.warehouse_agent_greedy import GreedyAgent
from warehouse_core import Cell, Episode, EpisodeRecorder, Layout, WarehouseEnv, record_episode
from warehouse_core.motion.grid import GridMotion
from warehouse_core.records.failure_modes import (
    CAUSE_SHARE,
    LOST_SHARE,
    MAX_SWING_CELLS,
    MIN_STEPS,
    MODES,
    ROUNDS,
    Diagnosis,
    diagnose,
    fewest_steps,
)
from warehouse_core.world.actions import ACTIONS
from warehouse_physics import Disturbances, RigidBodyMotion

WORDS = {"p": "PICK", "d": "DROP", ".": "WAIT"}

LINE = ["P..D"]
LONG = ["P" + "." * 40 + "D"]
HALL = ["P......", ".......", ".......", "......D"]
RING = [".....", ".###.", ".###.", ".....", "....P", "....D"]
ROUND = "EEEESSSWWWWNNN"
"""One round about the block of ``RING``, from its north-west corner."""
POCKET = ["......", ".###..", "...#.P", ".###..", "D....."]
"""A robot that drives from the west straight to the pickup ends in a dead end."""


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


def named(*args: Any, **settings: Any) -> Diagnosis:
    return diagnose(drive(*args, **settings))


class Missing(GridMotion):
    """Replaces the moves of some steps by ``instead``, with nothing in the way."""

    def __init__(self, steps: Iterable[int], instead: Cell = (0, 0)) -> None:
        super().__init__()
        self.steps, self.instead, self.step = set(steps), instead, -1

    def advance(self, displacements: Sequence[Cell], loaded: Sequence[bool]) -> Any:
        self.step += 1
        return super().advance([self.instead] if self.step in self.steps else displacements, loaded)


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
def test_every_mode_has_an_example(mode: str) -> None:
    assert diagnose(EXAMPLES[mode]).mode == mode


def test_the_examples_are_all_modes() -> None:
    assert tuple(EXAMPLES) == MODES


def test_the_thresholds() -> None:
    assert (MIN_STEPS, MAX_SWING_CELLS, ROUNDS, CAUSE_SHARE, LOST_SHARE) == (8, 4, 3, 0.4, 0.5)


# Delivered.


def test_a_delivery_is_compared_with_the_shortest_path() -> None:
    sentence = "delivered in 7 steps; the shortest way takes 5"
    assert named(LINE, (0, 0), "p.EEE.d")[:5] == ("delivered", ((0, 3),), 7, 5, sentence)


def test_a_delivery_after_detours_is_a_delivery() -> None:
    assert named(LINE, (0, 0), "EW" * 50 + "." * 50 + "pEEEd").mode == "delivered"


def test_a_delivery_with_the_last_battery_unit_is_a_delivery() -> None:
    assert named(LINE, (0, 0), "pEEEd", battery=5, max_steps=5).mode == "delivered"


def test_a_robot_that_starts_loaded_needs_no_pickup() -> None:
    assert named(["..D"], (0, 0), "EEd", loaded=True)[:4] == ("delivered", ((0, 2),), 3, 3)


# Unreachable.


@pytest.mark.parametrize(
    ("rows", "loaded", "cells", "sentence"),
    [
        (["...."], False, (), "there is no pickup"),
        (["D..."], False, (), "there is no pickup"),
        (["P..."], False, (), "there is no dropoff"),
        (["P..."], True, (), "there is no dropoff"),
        ([".D#P"], False, ((0, 3),), "no way leads from (0, 0) to the pickup at (0, 3)"),
        ([".P#D"], False, ((0, 3),), "no way leads from (0, 0) to the dropoff at (0, 3)"),
        ([".P#D"], True, ((0, 3),), "no way leads from (0, 0) to the dropoff at (0, 3)"),
        ([".#PD"], False, ((0, 2),), "no way leads from (0, 0) to the pickup at (0, 2)"),
        ([".#PD"], True, ((0, 3),), "no way leads from (0, 0) to the dropoff at (0, 3)"),
        (
            [".#PP", ".#PD"],
            False,
            ((0, 2), (0, 3), (1, 2)),
            "no way leads from (0, 0) to the pickup at (0, 2), (0, 3) or (1, 2)",
        ),
    ],
)
def test_unreachable_stations_are_named(
    rows: list[str], loaded: bool, cells: tuple[Cell, ...], sentence: str
) -> None:
    found = named(rows, (0, 0), "." * 30, loaded=loaded, max_steps=30)
    assert found[:5] == ("unreachable", cells, 30, None, sentence)


@pytest.mark.parametrize(
    ("rows", "loaded"),
    [([".D#P"], True), ([".PD#P"], False), ([".PD#D"], False), ([".PD#PD"], False)],
)
def test_one_reachable_station_is_enough(rows: list[str], loaded: bool) -> None:
    assert named(rows, (0, 0), "", loaded=loaded).mode == "unfinished"


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
    sentence = "it was stopped 3 steps short of the delivery"
    assert diagnose(recorder.episode)[:5] == ("unfinished", ((0, 0),), 3, None, sentence)
    for _ in range(MIN_STEPS):
        recorder.step("WAIT")
    assert diagnose(recorder.episode).mode == "ineffective"


# Stalled.


def test_a_robot_that_mostly_misses_its_target_cell_is_stalled() -> None:
    backend = Missing(range(2, 20))
    found = named(LONG, (0, 20), "W" * 20, max_steps=20, backend=backend)
    sentence = "18 of 20 steps missed their cell with nothing in the way, 18 of them from (0, 18)"
    assert found[:5] == ("stalled", ((0, 18),), 18, 21 + 1 + 40 + 1 - 0, sentence)


def test_the_cell_of_most_misses_is_the_evidence() -> None:
    backend = Missing([0, 1, 2, *range(4, 12), *range(14, 18)])
    found = named(LONG, (0, 20), "W" * 18, max_steps=18, backend=backend)
    assert (found.mode, found.cells, found.steps) == ("stalled", ((0, 19),), 15)
    assert "8 of them from (0, 19)" in found.sentence


def test_a_wait_that_ends_in_another_cell_is_a_miss() -> None:
    found = named(HALL, (1, 3), ".E" * 10, backend=Missing(range(0, 20, 2), instead=(0, -1)))
    assert (found.mode, found.steps) == ("stalled", 10)


@pytest.mark.parametrize(
    ("misses", "mode"), [(MIN_STEPS - 1, "unfinished"), (MIN_STEPS, "stalled")]
)
def test_a_stall_needs_a_minimum_of_misses(misses: int, mode: str) -> None:
    assert named(LONG, (0, 40), "W" * 20, backend=Missing(range(misses))).mode == mode


@pytest.mark.parametrize(("bumps", "mode"), [(18, "stalled"), (19, "ineffective")])
def test_a_stall_needs_a_minimum_share_of_the_lost_steps(bumps: int, mode: str) -> None:
    actions = "W" * 12 + "N" * bumps
    assert named(LONG, (0, 40), actions, backend=Missing(range(12))).mode == mode


def test_misses_that_lose_no_steps_are_not_a_stall() -> None:
    slides_on = Missing(range(0, 36, 2), instead=(0, -1))
    assert named(LONG, (0, 40), ".W" * 18, backend=slides_on).mode == "unfinished"


def test_a_bump_is_not_a_miss() -> None:
    assert named(LINE, (0, 1), "N" * 40).mode == "ineffective"


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


# Ineffective.


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


@pytest.mark.parametrize(("waits", "mode"), [(9, "wandering"), (10, "ineffective")])
def test_half_of_the_lost_steps_without_effect_explain_the_failure(waits: int, mode: str) -> None:
    actions = "".join(f"{move}." for move in "EEEESSWWWW"[:waits]) + "EEEESSWWWW"[waits:]
    assert named(HALL, (1, 0), actions).mode == mode


def test_steps_with_an_effect_are_not_counted() -> None:
    moved = Missing(range(0, 40, 2), instead=(0, 1))
    assert named(HALL, (1, 3), ".W" * 20, backend=moved).mode == "stalled"


# Oscillation.


@pytest.mark.parametrize(
    ("actions", "cells", "sentence"),
    [
        ("EW" * 20, ((1, 3), (1, 4)), "swung between (1, 3) and (1, 4) for the last 40 steps"),
        (
            "EWWE" * 10,
            ((1, 3), (1, 4), (1, 2)),
            "swung between (1, 3), (1, 4) and (1, 2) for the last 40 steps",
        ),
        (
            "ESWN" * 10,
            ((1, 3), (1, 4), (2, 4), (2, 3)),
            "swung between (1, 3), (1, 4), (2, 4) and (2, 3) for the last 40 steps",
        ),
        (".NS" * 9, ((1, 3), (0, 3)), "swung between (1, 3) and (0, 3) for the last 27 steps"),
        (
            "WWE" + "NS" * 9,
            ((1, 2), (0, 2)),
            "swung between (1, 2) and (0, 2) for the last 18 steps",
        ),
        ("WNSE" * 5 + "." * 18, ((1, 3),), "stood on (1, 3) for the last 18 steps"),
    ],
)
def test_the_cells_of_an_oscillation_are_named(
    actions: str, cells: tuple[Cell, ...], sentence: str
) -> None:
    found = named(HALL, (1, 3), actions)
    assert (found.mode, found.cells, found.sentence) == ("oscillation", cells, sentence)
    assert f" {found.steps} steps" in sentence


def test_a_cell_visited_before_the_oscillation_is_not_named() -> None:
    assert named(HALL, (1, 0), "EE" + "EW" * 20).cells == ((1, 2), (1, 3))


def test_a_pattern_of_fewer_cells_is_preferred_unless_it_is_short() -> None:
    found = named(HALL, (1, 3), "ESWN" * 5 + "EW" * 20)
    assert (found.cells, found.steps) == (((1, 3), (1, 4)), 40)
    found = named(HALL, (1, 3), "ESWN" * 20 + "EW" * 5)
    assert (len(found.cells), found.steps) == (4, 90)


def test_an_oscillation_ends_when_the_item_is_taken() -> None:
    found = named(["DP..."], (0, 1), "EW" * 6 + "p" + "EW" * 6, max_steps=25)
    assert (found.mode, found.steps) == ("oscillation", 12)


@pytest.mark.parametrize(
    ("swings", "mode"), [(MIN_STEPS - 2, "unfinished"), (MIN_STEPS - 1, "oscillation")]
)
def test_an_oscillation_needs_a_minimum_of_steps(swings: int, mode: str) -> None:
    # The last step of the path to it belongs to it.
    assert named(LONG, (0, 40), "W" * 20 + ("EW" * MIN_STEPS)[:swings]).mode == mode


@pytest.mark.parametrize(("bumps", "mode"), [(15, "wandering"), (16, "oscillation")])
def test_an_oscillation_needs_a_minimum_share_of_the_lost_steps(bumps: int, mode: str) -> None:
    assert named(HALL, (1, 0), "EEEESSWWWWNN" * 2 + "W" * bumps).mode == mode


def test_the_last_of_two_oscillations_is_named() -> None:
    found = named(HALL, (1, 0), "EW" * 13 + "SEEEES" + "EW" * 12)
    assert (found.mode, found.cells, found.steps) == ("oscillation", ((3, 4), (3, 5)), 24)


def test_an_oscillation_that_ended_early_is_not_the_mode() -> None:
    assert named(HALL, (1, 0), "EW" * 20 + "EESSWWNN" * 2 + "ESEESW").mode == "wandering"


@pytest.mark.parametrize(
    ("cells", "mode"), [(MAX_SWING_CELLS, "oscillation"), (MAX_SWING_CELLS + 1, "wandering")]
)
def test_few_cells_in_any_order_are_an_oscillation(cells: int, mode: str) -> None:
    ways = ["E" * (cells - 2) + "WE" * k + "E" + "W" * (cells - 1) for k in range(1, 5)]
    assert named(HALL, (1, 0), "".join(ways)).mode == mode


@pytest.mark.parametrize(("visits", "mode"), [(0, "oscillation"), (-1, "wandering")])
def test_more_cells_are_an_oscillation_if_they_recur_in_order(visits: int, mode: str) -> None:
    moves = ROUNDS * len(ROUND) - 1 + visits
    assert named(RING, (0, 0), (ROUND * ROUNDS)[:moves]).mode == mode


def test_a_loop_is_named_with_all_its_cells() -> None:
    found = named(RING, (0, 0), "E.N" + ROUND[1:] + ROUND * 4)
    sentence = "went round and round over 14 cells, (0, 0) among them, for the last 72 steps"
    assert (found.mode, found.steps, found.sentence) == ("oscillation", 72, sentence)
    assert found.cells[:3] == ((0, 0), (0, 1), (0, 2))
    assert len(set(found.cells)) == len(found.cells) == 14


def test_a_loop_may_start_late() -> None:
    found = named(RING, (3, 4), "NNNWWWW" + ROUND * 4)
    assert (found.mode, found.steps) == ("oscillation", 56)


def test_a_figure_of_eight_is_a_loop() -> None:
    found = named(HALL, (1, 3), "EESSWWNNWWSSEENN" * 4)
    assert (found.mode, len(found.cells), found.steps) == ("oscillation", 13, 64)


@pytest.mark.parametrize("seed", range(4))
def test_in_a_dead_end_the_greedy_agent_oscillates_unless_it_escapes(seed: int) -> None:
    def diagnosis(escape_steps: int) -> Diagnosis:
        env = WarehouseEnv(POCKET, (2, 0), battery=60)
        agent = GreedyAgent(seed, escape_steps=escape_steps)
        return diagnose(record_episode(env, agent, randomize=False))

    assert diagnosis(0)[:3] == ("oscillation", ((2, 1), (2, 2)), 59)
    assert diagnosis(3).mode in ("wandering", "delivered")


@pytest.mark.parametrize("more", range(8))
def test_a_loop_is_found_wherever_the_episode_ends(more: int) -> None:
    actions = ("WEWEESWN" * 6)[: 40 + more]
    found = named(HALL, (1, 3), actions)
    assert (found.mode, len(found.cells), found.steps) == ("oscillation", 5, len(actions))


# Wandering.


def test_moves_without_progress_are_wandering() -> None:
    found = named(HALL, (1, 0), "EEEESSWWWWNN" * 2)
    sentence = "came no nearer in 24 moves over 12 cells"
    assert found[:5] == ("wandering", ((1, 0),), 24, 12, sentence)


@pytest.mark.parametrize(("straight", "mode"), [(13, "wandering"), (14, "unfinished")])
def test_wandering_starts_when_half_of_the_moves_are_lost(straight: int, mode: str) -> None:
    found = named(LONG, (0, 40), "WWE" * 13 + "W" * straight)
    assert found.mode == mode
    if mode == "wandering":
        assert found.steps == 26
        assert found.sentence == "came 26 steps nearer to the delivery in 52 moves over 27 cells"


@pytest.mark.parametrize(
    ("moves", "mode"), [(MIN_STEPS - 1, "unfinished"), (MIN_STEPS, "wandering")]
)
def test_wandering_needs_a_minimum_of_moves(moves: int, mode: str) -> None:
    assert named(HALL, (1, 0), "EESSWWNN"[:moves]).mode == mode


def test_waits_on_a_straight_path_are_not_wandering() -> None:
    assert named(LONG, (0, 40), "W." * 30).mode == "ineffective"
    assert named(LONG, (0, 40), "W" * 15 + "." * (MIN_STEPS - 1)).mode == "unfinished"


@pytest.mark.parametrize(
    ("actions", "mode"), [("EW" * 6, "oscillation"), ("EEESSWWWNN" * 2, "wandering")]
)
def test_the_sentence_counts_other_misses(actions: str, mode: str) -> None:
    found = named(HALL, (1, 0), "WW" + actions, backend=Missing(range(2)))
    assert found.mode == mode
    assert found.sentence.endswith("; 2 steps missed their cell")


def test_progress_is_measured_along_paths() -> None:
    # Straight towards the pickup, into a dead end: every step makes the path longer.
    rows = ["...........", ".#########.", ".........#P", ".#########.", "D.........."]
    found = named(rows, (2, 0), "EEEEEEEE")
    assert (found.mode, found.steps) == ("wandering", 8)


# Budgets.


@pytest.mark.parametrize(
    ("settings", "mode", "ending"),
    [
        ({"battery": 15}, "battery depleted", "the battery ran out"),
        ({"max_steps": 15}, "out of time", "the time ran out"),
        ({"battery": 15, "max_steps": 15}, "battery depleted", "the battery ran out"),
        ({}, "unfinished", "it was stopped"),
    ],
)
def test_a_robot_on_its_way_failed_by_the_budget_that_ended_first(
    settings: dict[str, int], mode: str, ending: str
) -> None:
    episode = drive(LONG, (0, 20), "W" * 15, **settings)
    sentence = f"{ending} 48 steps short of the delivery; the shortest way takes 63"
    assert diagnose(episode)[:5] == (mode, ((0, 5),), 48, 63, sentence)
    assert episode.outcome == mode


def test_the_sentence_for_one_step_short_is_singular() -> None:
    found = named(LINE, (0, 0), "pEEE", max_steps=4)
    assert (
        found.sentence == "the time ran out 1 step short of the delivery; the shortest way takes 5"
    )


def test_an_episode_without_a_step_is_unfinished() -> None:
    assert named(LINE, (0, 1), "")[:4] == ("unfinished", ((0, 1),), 6, 6)


# Charging.

CHARGED = ["C" + "." * 30 + "PD"]


def test_waiting_that_charges_is_not_lost() -> None:
    found = named(CHARGED, (0, 0), "." * 25 + "E" * 10, units=5, battery=300, max_steps=35)
    assert (found.mode, found.steps) == ("out of time", 24)


def test_waiting_on_a_charger_with_a_full_battery_is_ineffective() -> None:
    found = named(CHARGED, (0, 0), "." * 25, units=15, battery=20, max_steps=25)
    assert (found.mode, found.steps) == ("ineffective", 24)
    assert found.sentence == "24 waits: at (0, 0)"


def test_charging_at_the_end_is_no_oscillation() -> None:
    found = named(CHARGED, (0, 12), "W" * 12 + "." * 20, units=20, battery=300, max_steps=32)
    assert (found.mode, found.steps) == ("wandering", 12)


def test_a_loop_with_a_charger_in_it_is_an_oscillation() -> None:
    found = named(CHARGED, (0, 0), "EW." * 8, battery=300, units=20)
    assert (found.mode, found.steps) == ("oscillation", 16)


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


def drawn(layout: Layout, data: Any) -> tuple[Cell, str, dict[str, Any]]:
    """Draw a start, actions with repetitions, and settings."""
    start = layout.open_cell(data.draw(st.integers(0, len(layout.open_cells) - 1)))
    parts = st.tuples(st.text("NESWNESW.pd?", max_size=6), st.integers(1, 12))
    actions = "".join(part * times for part, times in data.draw(st.lists(parts, max_size=5)))
    limits = st.integers(1, 60)
    settings = {
        "battery": data.draw(limits),
        "max_steps": data.draw(limits),
        "loaded": data.draw(st.booleans()),
    }
    return start, actions, settings


@settings(max_examples=40)
@given(LAYOUTS, st.data())
def test_the_diagnosis_of_any_episode_is_consistent(layout: Layout, data: Any) -> None:
    start, actions, limits = drawn(layout, data)
    episode = drive(layout.rows, start, actions, **limits)
    before = copy.deepcopy(episode)
    found = diagnose(episode)
    assert episode == before
    check_evidence(episode, found)


@pytest.mark.parametrize("seed", range(10))
@pytest.mark.parametrize("battery", [12, 200])
def test_the_diagnosis_of_any_agent_is_consistent(
    seed: int, battery: int, clumsy_agent: Any
) -> None:
    clumsy_agent.seed = seed
    for agent in (clumsy_agent, GreedyAgent(seed, escape_steps=seed % 4)):
        episode = record_episode(WarehouseEnv(battery=battery), agent, seed=seed)
        check_evidence(episode, diagnose(episode))


def check_evidence(episode: Episode, found: Diagnosis) -> None:
    assert found.mode in MODES
    assert found.sentence == found.sentence.strip() != ""
    assert (found.mode == "delivered") == episode.terminated
    if found.mode in MODES[-3:]:
        assert found.mode == episode.outcome
    if found.mode == "unreachable":
        reached = episode.layout.reachable_from(episode.cells[-1])
        stations = episode.layout.pickups + episode.layout.dropoffs
        assert set(found.cells) <= set(stations) - reached
        return
    assert set(found.cells) <= set(episode.cells)
    if found.mode == "oscillation":
        units = zip(episode.cells[1:], pairwise(episode.battery), strict=True)
        cells = [episode.cells[0], *(cell for cell, (a, b) in units if b <= a)]
        assert set(cells[-1 - found.steps :]) == set(found.cells)
    if found.mode in ("stalled", "oscillation", "wandering"):
        assert MIN_STEPS <= found.steps <= episode.steps


MIRROR = {"cells": lambda row, col, height, width: (row, width - 1 - col), "NESW": "NWSE"}
TRANSPOSE = {"cells": lambda row, col, height, width: (col, row), "NESW": "WSEN"}


@pytest.mark.parametrize("turn", [MIRROR, TRANSPOSE], ids=["mirror", "transpose"])
@settings(max_examples=40)
@given(LAYOUTS, st.data())
def test_a_mirrored_or_transposed_episode_has_the_same_mode(
    turn: dict[str, Any], layout: Layout, data: Any
) -> None:
    start, actions, limits = drawn(layout, data)

    def seen(cell: Cell) -> Cell:
        turned: Cell = turn["cells"](*cell, layout.height, layout.width)
        return turned

    tiles = {
        seen((row, col)): tile
        for row, line in enumerate(layout.rows)
        for col, tile in enumerate(line)
    }
    last_row, last_col = max(tiles)
    rows = ["".join(tiles[row, col] for col in range(last_col + 1)) for row in range(last_row + 1)]
    turned = actions.translate(str.maketrans("NESW", turn["NESW"]))
    one = named(layout.rows, start, actions, **limits)
    other = named(rows, seen(start), turned, **limits)
    assert other[0] == one[0]
    assert other[2:4] == one[2:4]
    if one.mode == "unreachable":
        assert set(other.cells) == set(map(seen, one.cells))
    else:
        assert other.cells == tuple(map(seen, one.cells))


def test_an_action_may_be_a_word_in_any_case_or_an_index() -> None:
    for example in EXAMPLES.values():
        words = copy.deepcopy(example)
        words.actions = [str(action).lower() for action in example.actions]
        assert diagnose(words) == diagnose(example)
        indices = copy.deepcopy(example)
        indices.actions = [ACTIONS.index(str(action)) for action in example.actions]
        assert diagnose(indices) == diagnose(example)


def test_agent_seed_and_reasons_do_not_change_the_diagnosis() -> None:
    for example in EXAMPLES.values():
        twin = copy.deepcopy(example)
        twin.agent, twin.seed, twin.reasons = "somebody", 7, ["why not"] * example.steps
        assert diagnose(twin) == diagnose(example)


@pytest.mark.parametrize("mode", MODES)
def test_a_loaded_record_has_the_same_mode(mode: str, tmp_path: Path) -> None:
    EXAMPLES[mode].save(tmp_path / "episode.npz")
    assert diagnose(Episode.load(tmp_path / "episode.npz")) == diagnose(EXAMPLES[mode])


@pytest.mark.parametrize("seed", range(2))
def test_nominal_physics_has_the_same_diagnosis(seed: int) -> None:
    found = [
        diagnose(
            record_episode(
                WarehouseEnv(battery=60, backend=backend),
                GreedyAgent(seed, escape_steps=3 * (seed % 2)),
                seed=seed,
            )
        )
        for backend in ("grid", "physics")
    ]
    assert found[0] == found[1]
