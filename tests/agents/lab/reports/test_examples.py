"""Example episodes with each outcome: their choice and their replays."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.command_line import write_mine
from helpers.results_files import row

from agents.lab.experiments.case import Case, make_case, run_task
from agents.lab.experiments.case import run_one as run_whole
from agents.lab.experiments.store import Store
from agents.lab.reports import examples
from agents.lab.reports.examples import Example, find_examples, replay
from agents.lab.reports.results import LONE, Experiment
from warehouse_core import Episode


@pytest.fixture
def store() -> Iterator[Store]:
    with Store("r.sqlite") as opened:
        yield opened


def found_in(store: Store, episodes: int = 12, **settings: object) -> list[Example]:
    case = make_case(settings)  # type: ignore[arg-type]
    store.add(store.case_ids([case])[0], run_task(case, range(episodes)).rows)
    return find_examples(Experiment(store, LONE))


def test_the_shortest_is_chosen_then_the_first_case_then_the_smallest_seed(store: Store) -> None:
    cases = [make_case({"memory": memory}) for memory in (1, 2)]
    first, second = store.case_ids(cases)
    store.add(first, [row(1, "stalled", 9), row(8, "stalled", 7), row(9, "stalled", 7)])
    store.add(second, [row(0, "stalled", 7), row(2, "stalled", 8), row(3, "delivered", 4)])
    store.add(first, [row(2, "delivered", 5)])
    assert find_examples(Experiment(store, LONE)) == [
        Example("delivered", cases[1], 3, 4, 2), Example("stalled", cases[0], 8, 7, 5),
    ]  # fmt: skip


def test_a_replay_shows_every_step_and_the_outcome_unless_it_has_changed(store: Store) -> None:
    found = found_in(store)[0]
    example = replay(found, run_own_code=True)
    assert found.mode == "delivered"
    assert example[:5] == found[:5]
    assert example.sentence.startswith(f"delivered in {found.steps} steps")
    assert example.track is not None
    assert example.track.steps == found.steps
    assert example.track.ending == "delivered"
    longer = replay(found._replace(steps=found.steps + 1), run_own_code=True)
    other = replay(found._replace(mode="stalled"), run_own_code=True)
    for changed in (longer, other):
        assert changed.track is None
        assert f"delivered after {found.steps} steps" in changed.sentence
    assert f"not delivered after {found.steps + 1}" in longer.sentence
    assert f"not stalled after {found.steps}" in other.sentence


def test_an_agent_that_has_changed_or_is_missing_has_no_replay(store: Store) -> None:
    write_mine("act", "pass", "'WAIT'")
    [found] = found_in(store, episodes=1, agent="mine.py:Mine", max_steps=12)
    assert replay(found, run_own_code=True).track
    write_mine("act", "pass", "1 / 0")
    changed = replay(found, run_own_code=True)
    Path("mine.py").unlink()
    gone = replay(found, run_own_code=True)
    for example, why in ((changed, "has changed since"), (gone, "cannot be read: ")):
        assert example.track is None
        assert example.sentence.startswith(
            "It cannot be run again: the code of agent 'mine.py:Mine'"
        )
        assert why in example.sentence


@pytest.mark.parametrize(
    ("backend", "steps", "why"),
    [
        ("grid", 10_001, "it has 10,001 steps, and the limit is 10,000"),
        ("physics", 1001, "it has 1,001 steps, and the limit is 1,000"),
    ],
)
def test_an_episode_that_is_too_long_is_not_run(
    monkeypatch: pytest.MonkeyPatch, backend: str, steps: int, why: str
) -> None:
    monkeypatch.delattr(examples, "run_one")
    example = replay(
        Example("stalled", make_case({"backend": backend}), 0, steps, 1), run_own_code=True
    )
    assert (example.sentence, example.track) == (f"It is not run again: {why}.", None)


def test_an_episode_that_takes_longer_than_in_the_results_is_stopped(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    episodes = []

    def run_one(case: Case, seed: int) -> Episode:
        episodes.append(run_whole(case, seed))
        return episodes[-1]

    monkeypatch.setattr(examples, "run_one", run_one)
    case = {
        **make_case({}),
        "max_steps": 10**9,
        "battery": 10**9,
        "tiles": ["####", "#PD#", "####"],
    }
    example = replay(Example("wandering", case, 0, 7, 1), run_own_code=True)
    assert " after 8 steps, not wandering after 7 steps" in example.sentence
    assert episodes[0].steps == 8


@pytest.mark.parametrize(
    ("fingerprint", "run_own_code", "words"),
    [({}, False, "--replays"), ({"fingerprint": "0" * 64}, True, "has changed")],
    ids=["without being asked", "that has changed"],
)
def test_a_user_agent_is_not_run(
    fingerprint: dict[str, str], run_own_code: bool, words: str
) -> None:
    Path("mine.py").write_text("open('ran', 'w')\nclass Mine:\n    pass\n")
    case = {**make_case({}), "agent": "mine.py:Mine"} | fingerprint
    example = replay(Example("wandering", case, 0, 5, 1), run_own_code=run_own_code)
    assert words in example.sentence
    assert example.track is None
    assert not Path("ran").exists()
