"""Fleets give the same results with NumPy and with the loops that Numba compiles, bit for bit."""

import pickle
from collections.abc import Callable, Iterator
from copy import copy, deepcopy
from typing import Any

import numpy as np
import pytest
from helpers.forms import use_loops

from warehouse_core import FleetEnv, GridMotion, Layout, Order, OrderQueue, People, shelf_layout
from warehouse_core.fleet import Battery, FleetBatch
from warehouse_core.motion.base import BatchOutcome
from warehouse_core.motion.grid import GridFleetBatch

SMALL, WIDE = Layout(["P..C", ".#..", "...D"]), Layout(["P.C.#D..", "..D....P"])
SHELVES = shelf_layout(2, 2, 3, pickups=2, dropoffs=2, chargers=2)

ENDS = ((0, 0), (0, 1))
CROSSING = [
    Order(step, step + 20, *ends) for step in range(0, 40, 4) for ends in (ENDS, ENDS[::-1])
]
"""Orders whose pickups are the dropoffs of others."""

KINDS: dict[str, dict[str, Any]] = {
    "one robot": {"robots": 1, "layout": SMALL},
    "robots only": {"robots": 6, "layout": SMALL},
    "flat batteries": {"robots": 5, "layout": SMALL, "battery": 25, "max_steps": 60},
    "ends on chargers": {"robots": 3, "layout": Layout(["CCC", "P.D"]), "battery": 4},
    "listed": {"robots": 2, "layout": WIDE, "orders": CROSSING},
    "no view": {"robots": 3, "layout": SMALL, "orders": 0.3, "view_radius": 0},
    "orders": {"robots": 6, "layout": SHELVES, "orders": 0.6, "late_penalty": 0.1},
    "queue": {"robots": 4, "layout": WIDE, "orders": OrderQueue(3), "team_reward": True},
    "people": {"robots": 4, "layout": SHELVES, "orders": 0.4, "people": People(5, "aisles")},
    "headings": {"robots": 5, "layout": SHELVES, "orders": 0.4, "moves": "turn", "people": 2},
    "joules": {"robots": 4, "layout": SMALL, "battery": Battery(900, "joules", knee=0.7)},
    "bodies": {"robots": 3, "layout": SMALL, "orders": 0.3, "backend": "physics"},
    "driving": {"robots": 2, "layout": SHELVES, "orders": 0.3, "backend": "driving"},
}
STEPS = {"bodies": 25, "driving": 40}


def flat(values: Any) -> list[Any]:
    """Return values in nested dictionaries as a list in which arrays can be compared exactly."""
    if isinstance(values, dict):
        return [(key, each) for key in values for each in flat(values[key])]
    if isinstance(values, np.ndarray):
        return [(values.dtype.str, values.shape, values.tobytes())]
    return [values]


def results(kind: str) -> Iterator[list[Any]]:
    """Yield everything that a fleet returns in each of its steps."""
    env = FleetEnv(**KINDS[kind])
    stream = np.random.default_rng(3)
    actions = len(env.settings.actions)
    observations, info = env.reset(seed=1)
    yield [*flat(observations), *flat(info)]
    for _ in range(STEPS.get(kind, 80)):
        chosen = stream.integers(0, actions + 1, env.settings.robots)  # one of them is invalid
        useful = np.argmax(info["action_mask"][:, ::-1], axis=1)
        chosen = np.where(stream.random(len(chosen)) < 0.5, actions - 1 - useful, chosen)
        observations, *flags, info = env.step(chosen)
        found = [*flat(observations), *(each for flag in flags for each in flat(flag))]
        paths = [outcome.path.tobytes() for outcome in env.last_motion]
        yield [*found, *flat(info), env.battery, paths]
        if all(env.ended):
            observations, info = env.reset()
    yield [env.measures, flat(env.observe(0)), env.cells, env.headings, env.loaded]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.filterwarnings("ignore:.*can keep")
def test_both_forms_give_equal_results(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    each = []
    for loops in (False, True):
        use_loops(monkeypatch, loops)
        each.append(list(results(kind)))
    for step, (arrays, loops) in enumerate(zip(*each, strict=True)):
        assert arrays == loops, step


def test_copies_of_a_fleet_go_on_like_it_in_both_forms(form: str) -> None:
    env, stream = FleetEnv(SHELVES, 4, orders=0.5, people=1), np.random.default_rng(1)
    env.reset(seed=3)
    env.step([4] * 4)
    actions = stream.integers(0, 7, (12, 4))
    copies = [env, deepcopy(env), pickle.loads(pickle.dumps(env))]
    found = [[flat(each.step(chosen)[0]) for chosen in actions] for each in copies]
    assert found[0] == found[1] == found[2]
    assert copies[0].measures == copies[1].measures == copies[2].measures


@pytest.mark.parametrize("orders", [None, 0.3])
def test_both_forms_give_equal_results_on_many_floors(orders: float | None, monkeypatch) -> None:
    each = []
    for loops in (False, True):
        use_loops(monkeypatch, loops)
        layouts, stream = [SMALL, WIDE, SMALL, SHELVES], np.random.default_rng(5)
        batch = FleetBatch(
            4, layouts, robots=4, orders=orders, people=1, max_steps=30, autoreset_mode="SameStep"
        )
        found = [flat(value) for value in batch.reset(seed=2)]
        for _ in range(50):
            step = batch.step(stream.integers(0, 7, batch.num_envs))
            found += [flat(value) for value in step]
        each.append([*found, [batch.measures(fleet) for fleet in range(4)]])
    assert each[0] == each[1]


class ForeignBatch(GridFleetBatch):
    """A motion whose outcomes are changed before they are returned."""

    def __init__(self, change: Callable[[BatchOutcome], BatchOutcome]) -> None:
        super().__init__([SMALL], 1.0, 2)
        self.change_outcome = change

    def advance(self, actions: Any, loaded: Any) -> BatchOutcome:
        return self.change_outcome(super().advance(actions, loaded))


class ForeignMotion(GridMotion):
    def __init__(self, change: Callable[[BatchOutcome], BatchOutcome]) -> None:
        super().__init__()
        self.change_outcome = change

    def fleet_batch(self, layouts: Any, robots: int) -> ForeignBatch:
        return ForeignBatch(self.change_outcome)


def test_loops_accept_outcomes_of_other_types(monkeypatch: pytest.MonkeyPatch) -> None:
    def other_types(outcome: BatchOutcome) -> BatchOutcome:
        return outcome._replace(
            cells=outcome.cells.astype(np.int32),  # type: ignore[arg-type]
            seconds=np.repeat(outcome.seconds, 2)[::2],
            stopped_by=outcome.stopped_by.tolist(),  # type: ignore[union-attr]
        )

    use_loops(monkeypatch, loops=True)
    fleets = [FleetEnv(SMALL, 2, backend=ForeignMotion(change)) for change in (copy, other_types)]
    for fleet in fleets:
        fleet.reset(seed=1)
    for actions in np.random.default_rng(0).integers(0, 7, (50, 2)):
        native, foreign = (fleet.step(actions) for fleet in fleets)
        assert flat(native[0]) == flat(foreign[0])
    assert fleets[0].measures == fleets[1].measures


def test_robots_that_fail_end_in_both_forms(monkeypatch: pytest.MonkeyPatch) -> None:
    each, failed = [], np.array([False, True])
    for loops in (False, True):
        use_loops(monkeypatch, loops)
        motion = ForeignMotion(lambda outcome: outcome._replace(failed=failed))
        fleet = FleetEnv(SMALL, 2, backend=motion)
        fleet.reset(seed=1)
        each.append([flat(part) for part in fleet.step(["N", "E"])])
        assert fleet.ended == [False, True]
    assert each[0] == each[1]


@pytest.mark.parametrize(
    "change",
    [
        lambda outcome: outcome._replace(cells=outcome.cells + 100),
        lambda outcome: outcome._replace(cells=outcome.cells - 100),
        lambda outcome: outcome._replace(stopped_by=outcome.stopped_by + 3),
        lambda outcome: outcome._replace(stopped_by=outcome.stopped_by - 2),
        lambda outcome: outcome._replace(joules=outcome.joules[:1]),
        lambda outcome: outcome._replace(blocked=outcome.blocked[:, None]),
    ],
)
def test_loops_read_no_outcome_that_leads_outside_of_their_tables(change, monkeypatch) -> None:
    use_loops(monkeypatch, loops=True)
    fleet = FleetEnv(SMALL, 2, backend=ForeignMotion(change))
    fleet.reset(seed=1)
    with pytest.raises(ValueError, match="the motion returned"):
        fleet.step(["WAIT", "WAIT"])
