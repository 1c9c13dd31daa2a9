"""Chipmunk's step compared with pymunk's, and errors in callbacks."""

import random
import signal
import sys
import threading
from collections.abc import Callable
from functools import partial

import numpy as np
import pymunk
import pytest
from helpers.rigid_bodies import EAST, LEDGE, STEPS, WEST, batch_in, motion_in, move

from warehouse_core import Layout, Outcome, random_layout
from warehouse_physics import Disturbances, RigidBodyMotion, stepping

HALL = Layout(["...."] * 3)
MOVES = 60

over_versions = pytest.mark.parametrize("known", [True, False], ids=["known", "later"])


@pytest.fixture
def known(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> bool:
    """Return whether the private parts of this version of pymunk are used."""
    monkeypatch.setattr(stepping, "IS_KNOWN", request.param and stepping.IS_KNOWN)
    return stepping.IS_KNOWN


def wander(robots: int, disturbances: Disturbances | None = None) -> list[Outcome]:
    """Move at random, with an item in half of the moves."""
    layout, stream = random_layout(6, 7, 0.2, seed=4), random.Random(robots)
    motion = RigidBodyMotion(disturbances=disturbances)
    motion.reset(layout, [layout.open_cell(rank) for rank in range(robots)], 1)
    return [
        outcome
        for _ in range(MOVES)
        for outcome in motion.advance(
            stream.choices(STEPS, k=robots), [stream.random() < 0.5 for _ in range(robots)]
        )
    ]


def bits(outcomes: list[Outcome]) -> list[object]:
    return [(each._replace(path=None), each.path.tobytes()) for each in outcomes]


# The same steps, with Chipmunk's own function and with pymunk's.


@pytest.mark.parametrize("robots", [1, 4])
@pytest.mark.parametrize("disturbances", [None, Disturbances(0.1, [(1, 1)], drag_spread=0.5)])
def test_pymunks_own_step_gives_the_same_bits(robots, disturbances, monkeypatch) -> None:
    fast = wander(robots, disturbances)
    assert any(outcome.contacts for outcome in fast)
    monkeypatch.setattr(stepping, "IS_KNOWN", False)
    assert bits(wander(robots, disturbances)) == bits(fast)


@over_versions
def test_additions_and_removals_in_a_callback_wait_for_the_end_of_the_steps(known) -> None:
    motion = motion_in(LEDGE, (0, 0))
    move(motion, EAST)
    space, added = motion._arena.space, pymunk.Body(1.0, 1.0)
    wall = next(shape for shape in space.shapes if isinstance(shape, pymunk.Poly))
    hits, seen = motion._arena.stepper._hits, []
    note = hits._note

    def meddle(arbiter: pymunk.Arbiter) -> object:
        if not seen:
            space.add(added)
            space.remove(wall)
        seen.append((added in space.bodies, wall in space.shapes))
        return note(arbiter)

    hits._note = meddle
    move(motion, WEST)
    assert seen[0] == (False, True)
    assert (added in space.bodies, wall in space.shapes) == (True, False)


# Errors and interrupts in callbacks.


def break_notes(motion: RigidBodyMotion, fail: Callable[[], object]) -> None:
    motion._arena.stepper._hits._note = lambda arbiter: fail()


def interrupt() -> None:
    signal.raise_signal(signal.SIGINT)


def divide_by_zero() -> None:
    _ = 1 / 0


@over_versions
@pytest.mark.usefixtures("known", "interrupts_raise")
@pytest.mark.parametrize(
    ("fail", "error"),
    [(divide_by_zero, ZeroDivisionError), (interrupt, KeyboardInterrupt), (sys.exit, SystemExit)],
)
def test_an_error_while_a_hit_is_noted_ends_the_action(fail, error) -> None:
    motion = motion_in(LEDGE, (0, 0))
    note = motion._arena.stepper._hits._note
    break_notes(motion, fail)
    with pytest.raises(error):
        move(motion, EAST)
    motion._arena.stepper._hits._note = note
    assert len(move(motion, WEST).contacts) == 1


# Calls that overlap.


def test_an_action_inside_an_action_raises() -> None:
    motion = motion_in(LEDGE, (0, 0))
    note = motion._arena.stepper._hits._note
    break_notes(motion, lambda: move(motion, WEST))
    with pytest.raises(RuntimeError, match=r"^advance\(\) while another call .* of its own$"):
        move(motion, EAST)
    motion._arena.stepper._hits._note = note
    assert move(motion, WEST).contacts


def test_a_motion_in_several_threads_raises_and_goes_on() -> None:
    motion, batch = motion_in(HALL, (1, 1)), batch_in([HALL] * 2)
    calls = [
        lambda: motion.advance([EAST], [False]),
        lambda: batch.advance(np.array([1, 1]), np.zeros(2, bool)),
    ]
    errors: list[str] = []

    def repeat(action: Callable[[], object]) -> None:
        for _ in range(MOVES):
            try:
                action()
            except RuntimeError as error:
                errors.append(str(error))

    threads = [threading.Thread(target=repeat, args=[each]) for each in calls * 3]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert errors
    assert {error.split(" while ")[0] for error in errors} == {"advance()"}
    assert motion.advance([WEST], [False])[0].cell == (1, 2)


def test_robots_cannot_be_placed_during_an_action_of_a_batch() -> None:
    batch = batch_in([LEDGE])
    place = partial(batch.place, np.array([0]), np.array([0]))
    batch._parts[0].arena.stepper._hits._note = lambda arbiter: place()
    with pytest.raises(RuntimeError, match=r"^place\(\) while another call"):
        batch.advance(np.array([1]), np.zeros(1, bool))
    place()
