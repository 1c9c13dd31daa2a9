import numpy as np
from helpers.fleet_truth import EAST, PICK, WAIT

from warehouse_core.batch.tally import (
    BUSY,
    BY_PERSON,
    BY_ROBOT,
    BY_WALL,
    CHARGED,
    ENDED,
    HANDLED,
    MOVED,
    WAITED,
    Tally,
)
from warehouse_core.motion.base import NOTHING, WALL, BatchOutcome
from warehouse_core.world.moves import ACTION_SETS, COMPASS


def test_each_step_is_counted_by_what_stopped_the_robot() -> None:
    """Obstacles are numbered: the robots of a floor first, then its people."""
    robots, people = 3, 2
    stopped_by = [[0, robots - 1, robots], [robots + people - 1, WALL, NOTHING]]
    expected = [[BY_ROBOT, BY_ROBOT, BY_PERSON], [BY_PERSON, BY_WALL, MOVED]]
    tally = Tally(2, robots, people, ACTION_SETS[COMPASS])
    obstacles = np.array(stopped_by).ravel()
    cells, ones, none = np.zeros(6, np.intp), np.ones(6), np.array([], np.intp)
    for _ in range(2):
        outcome = BatchOutcome(cells, obstacles != NOTHING, ones, ones, obstacles)
        tally.add(np.full(6, EAST), outcome, None, none, none)
    for floor, kinds in enumerate(expected):
        counts = tally.counts(floor)
        assert counts.sum() == 2 * robots
        assert [counts[kind, robot] for robot, kind in enumerate(kinds)] == [2] * robots


def test_a_robot_at_rest_waits_charges_handles_items_or_has_ended() -> None:
    kinds = [WAITED, BUSY, CHARGED, HANDLED, ENDED]
    tally = Tally(1, 5, 0, ACTION_SETS[COMPASS])
    outcome = BatchOutcome(
        np.zeros(5, np.intp), np.zeros(5, np.bool_), np.arange(5.0), np.ones(5),
        driving=np.arange(5) == kinds.index(BUSY),
    )  # fmt: skip
    actions = np.array([WAIT, WAIT, WAIT, PICK, EAST])
    charging, delivered = np.arange(5) == kinds.index(CHARGED), np.array([3])
    tally.add(actions, outcome, charging, delivered, np.array([kinds.index(ENDED)]))
    assert [tally.counts(0)[kind].tolist() for kind in kinds] == np.eye(5, dtype=int).tolist()
    measures = tally.measures(0, 1, None)
    assert (measures.seconds, measures.joules, measures.delivered) == (4.0, 5.0, 1)
