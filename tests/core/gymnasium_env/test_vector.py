"""The vector environment equals Gymnasium's own vector of single environments."""

import copy
import inspect
import pickle
from contextlib import closing
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from helpers.gymnasium_envs import (
    CORRIDOR,
    HAS_MODES,
    MODES,
    NAME,
    ROOM,
    make_sync,
    make_vec,
    plain,
    same,
)

from warehouse_core import LayoutError, random_layout
from warehouse_core.gymnasium_env import WarehouseGymnasiumEnv
from warehouse_core.gymnasium_env.spaces import FORMS
from warehouse_core.gymnasium_env.vector import WarehouseVectorEnv

NORTH, EAST, SOUTH, WEST, WAIT, PICK, DROP = range(7)

ONLY_BATCH = ("num_envs", "autoreset_mode", "max_episode_steps")

over_forms = pytest.mark.parametrize("form", FORMS)
allow_fork = pytest.mark.filterwarnings("ignore:This process .* is multi-threaded")
"""Python 3.12 warns of each fork in a process with threads; NumPy starts some."""


def assert_infos_equal(
    found: dict[str, Any], expected: dict[str, Any], is_exact: bool = True
) -> None:
    """Compare each key in the rows to which it applies; motions have a different form."""
    for key in sorted({*found, *expected} - {"motion", "_motion"}):
        if key.startswith("_"):
            assert found[key].dtype == expected[key].dtype == bool
            assert found[key].tolist() == expected[key].tolist(), key
            continue
        rows = np.flatnonzero(expected[f"_{key}"])
        if key == "final_info":
            assert_infos_equal(found[key], expected[key], is_exact)
        elif key == "final_obs":
            assert found[key].dtype == expected[key].dtype == object
            for one, other in zip(found[key], expected[key], strict=True):
                assert (one is None) == (other is None)
                assert one is None or equal_values(one, other)
        else:
            assert found[key].dtype == expected[key].dtype
            assert found[key].shape == expected[key].shape
            assert np.array_equal(found[key][rows], expected[key][rows]), key
    if "_motion" not in found:
        assert "_motion" not in expected
        return
    count = len(found["_motion"])
    rows = np.flatnonzero(found["_motion"])
    nothing = np.zeros(count, bool)
    assert rows.tolist() == np.flatnonzero(expected.get("_motion", nothing)).tolist()
    for row in rows:
        for key, values in found["motion"].items():
            if not key.startswith("_"):
                # Bodies of a batch share a space, where terms are added in another order.
                one = getattr(expected["motion"][row], key)
                assert values[row] == one if is_exact else values[row] == pytest.approx(one)


def equal_values(value: Any, other: Any) -> bool:
    """Compare observations, whose numbers may be of Python or NumPy."""
    if isinstance(value, dict):
        return value.keys() == other.keys() and all(
            equal_values(value[key], other[key]) for key in value
        )
    return np.array_equal(value, other) and getattr(value, "shape", ()) == np.shape(other)


@pytest.mark.parametrize(
    ("mode", "form", "randomize", "backend"),
    [(mode, "dict", True, backend) for mode in MODES for backend in ("grid", "physics")]
    + [
        (MODES[0], "dict", False, "grid"),
        (MODES[0], "vector", True, "grid"),
        (MODES[len(MODES) // 2], "image", True, "grid"),
    ],
)
def test_a_batch_equals_a_sync_vector_env_bit_for_bit(mode, form, randomize, backend) -> None:
    count = 5
    settings = {"layout": ROOM, "observation": form, "randomize": randomize, "max_steps": 14}
    settings["backend"] = backend
    batch, sync = (kind(count, mode, **settings) for kind in (make_vec, make_sync))
    for name in ("observation_space", "single_observation_space", "action_space"):
        assert getattr(batch, name) == getattr(sync, name)
    assert batch.single_action_space == sync.single_action_space
    if HAS_MODES:
        assert batch.metadata["autoreset_mode"] is sync.metadata["autoreset_mode"]
        assert batch.autoreset_mode is sync.autoreset_mode

    def reset(**given: Any) -> None:
        # Gymnasium removes the mask from its options, so each gets a copy.
        found = [each.reset(**copy.deepcopy(given)) for each in (batch, sync)]
        assert same(found[0][0], found[1][0])
        assert found[0][0] in batch.observation_space
        assert_infos_equal(found[0][1], found[1][1])
        assert batch.np_random_seed == sync.np_random_seed

    reset(seed=21)
    stream, ends = np.random.default_rng(1), 0
    ended = np.zeros(count, bool)
    for number in range(120):
        if mode == "Disabled" and ended.any():
            reset(options={"reset_mask": ended})
        elif number % 30 == 29:
            # From here on the rows have different step counts.
            given = {"options": {"reset_mask": np.arange(count) < 2}} if HAS_MODES else {}
            reset(seed=[3, None, 4, None, 5], **given)
        # PICK and DROP are frequent, so that some have an effect.
        actions = stream.choice([0, 1, 2, 3, 4, 5, 5, 6, 6], size=count)
        found = [each.step(actions) for each in (batch, sync)]
        for one, other in zip(*(each[:4] for each in found), strict=True):
            assert same(one, other)
        assert found[0][0] in batch.observation_space
        assert_infos_equal(found[0][4], found[1][4], backend == "grid")
        ended = found[0][2] | found[0][3]
        ends += int(found[0][2].sum())
    assert ends
    batch.close()
    sync.close()


@allow_fork
@pytest.mark.parametrize("limit", [3, 9, -1])
def test_a_limit_of_steps_is_that_of_gymnasiums_wrapper(limit: int) -> None:
    settings = {"layout": ROOM, "max_steps": 6, "max_episode_steps": limit}
    batch, sync = (
        gymnasium.make_vec(NAME, 2, way, **settings) for way in ("vector_entry_point", "sync")
    )
    assert batch.single_observation_space == sync.single_observation_space
    assert batch.spec.max_episode_steps == min(limit % 10, 6)
    with closing(batch), closing(sync):
        assert same(batch.reset(seed=2)[0], sync.reset(seed=2)[0])
        for actions in np.random.default_rng(4).integers(5, size=(15, 2)):
            assert same(batch.step(actions)[:4], sync.step(actions)[:4])
    with closing(gymnasium.make_vec(batch.spec)) as again:
        assert (again.num_envs, again.spec.max_episode_steps) == (2, min(limit % 10, 6))


def test_rows_without_a_seed_have_the_seeds_that_they_report() -> None:
    env, other = (WarehouseVectorEnv(3, ROOM) for _ in range(2))
    known = env.np_random_seed
    start = env.reset()[0]
    assert env.np_random_seed == known
    assert len(set(known)) == 3
    assert same(other.reset(seed=known)[0], start)
    stream = other.np_random[1]
    before = stream.bit_generator.state
    other.reset()
    assert stream.bit_generator.state != before
    fixed = WarehouseVectorEnv(2, ROOM, randomize=False)
    fixed.reset(seed=7)
    assert fixed.np_random_seed == (7, 8)


@over_forms
def test_layouts_of_different_sizes_share_one_space(form: str) -> None:
    layouts = [CORRIDOR, ROOM, random_layout(7, 4, 0.2, seed=0), ROOM]
    batch = WarehouseVectorEnv(4, layouts, observation=form, render_mode="rgb_array", max_steps=9)
    extent = WarehouseVectorEnv(1, ["." * 6] * 7, observation=form, max_steps=9)
    assert batch.single_observation_space == extent.single_observation_space
    observation, _ = batch.reset(seed=0)
    for actions in np.random.default_rng(0).integers(7, size=(20, 4)):
        assert observation in batch.observation_space
        observation, *_ = batch.step(actions)
    sizes = [picture.shape for picture in batch.render()]
    pixels = sizes[0][0]
    assert sizes == [(each.height * pixels, each.width * pixels, 3) for each in layouts]


def test_invalid_calls_raise_the_errors_of_gymnasium() -> None:
    batch = WarehouseVectorEnv(2, max_steps=1, autoreset_mode="Disabled")
    with pytest.raises(ResetNeeded, match=r"step\(\) needs a reset\(\) before it"):
        batch.step([0, 0])
    with pytest.raises(ResetNeeded):
        batch.action_masks()
    with pytest.raises(ResetNeeded, match=r"the first reset\(\) must be of all rows"):
        batch.reset(options={"reset_mask": np.ones(2, bool)})
    batch.reset(seed=0)
    batch.step([WAIT, WAIT])
    before = pickle.dumps(batch)
    with pytest.raises(ResetNeeded, match="2 rows have ended, row 0 first"):
        batch.step([0, 0])
    with pytest.raises(ValueError, match="unknown options: 'layout'; allowed: reset_mask"):
        batch.reset(seed=1, options={"layout": ROOM})
    with pytest.raises(TypeError, match="the mask is"):
        batch.reset(seed=1, options={"reset_mask": [True, False]})
    with pytest.raises(ValueError, match="num_envs is 0"):
        WarehouseVectorEnv(0)
    with pytest.raises(ValueError, match="autoreset_mode is 'Never'"):
        WarehouseVectorEnv(2, autoreset_mode="Never")
    with pytest.raises(ValueError, match="allowed: None, rgb_array"):
        WarehouseVectorEnv(2, render_mode="human")
    with pytest.raises(LayoutError, match=r"^no\.txt: No such file"):
        WarehouseVectorEnv(2, ["no.txt", ROOM])
    assert pickle.dumps(batch) == before


def test_both_environments_have_the_same_arguments_in_the_same_order() -> None:
    single, batch = (
        list(inspect.signature(kind).parameters)
        for kind in (WarehouseGymnasiumEnv, WarehouseVectorEnv)
    )
    assert [name for name in batch if name not in ONLY_BATCH] == single


def test_a_batch_whose_construction_failed_can_be_closed() -> None:
    WarehouseVectorEnv.__new__(WarehouseVectorEnv).close_extras()


def test_the_picture_of_a_row_equals_that_of_a_single_environment() -> None:
    batch = WarehouseVectorEnv(3, ROOM, render_mode="rgb_array")
    with pytest.raises(ResetNeeded, match=r"needs a reset\(\) before it"):
        batch.render()
    batch.reset(seed=5)
    pictures = batch.render()
    assert type(pictures) is tuple
    for row, picture in enumerate(pictures):
        env = plain(layout=ROOM, render_mode="rgb_array")
        env.reset(seed=5 + row)
        assert same(picture, env.render())


def test_a_batch_can_be_copied_and_pickled() -> None:
    for form in FORMS:
        batch = WarehouseVectorEnv(3, ROOM, observation=form)
        batch.reset(seed=1)
        others = copy.deepcopy(batch), pickle.loads(pickle.dumps(batch))
        expected = batch.step([EAST, WEST, SOUTH]), batch.reset()
        for other in others:
            assert same((other.step([EAST, WEST, SOUTH]), other.reset()), expected)
