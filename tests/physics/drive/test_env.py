"""``WarehouseDrive-v0``: checkers, arguments, names, pictures and its vector form."""

import copy
import pickle

import gymnasium
import numpy as np
import pymunk
import pytest
from gymnasium.error import ResetNeeded
from gymnasium.utils.env_checker import check_env

from warehouse_core import DEFAULT_LAYOUT, Layout, LayoutError
from warehouse_physics import Disturbances, RigidBodyMotion, RobotSpec
from warehouse_physics.disturbances import Stop
from warehouse_physics.drive import DriveEnv, DriveVectorEnv

DISC = RobotSpec()
FORMS = [
    {"control": "velocity"},
    {"control": "wheels", "observation": "dict"},
    {"control": "force", "rays": 0},
    {"spec": DISC, "observation": "dict"},
    {"spec": DISC, "control": "force"},
    {"crates": 2, "obstacles": [(8.0, 2.0, 0.2)], "disturbances": Disturbances(odometry=0.1)},
]


@pytest.mark.parametrize("arguments", FORMS, ids=str)
def test_the_checker_of_gymnasium_finds_nothing(arguments):
    check_env(gymnasium.make("WarehouseDrive-v0", **arguments).unwrapped)


@pytest.mark.parametrize(
    ("action", "error", "message"),
    [
        ([np.nan, 0.0], ValueError, "must be finite"),
        ([0.0], ValueError, r"shape \(1,\); it must be \(2,\)"),
        ([[0.0, 0.0]], ValueError, r"shape \(1, 2\)"),
        (["a", "b"], TypeError, "must have numbers"),
        ([[0.0], 1.0], TypeError, "must have numbers"),
    ],
)
def test_a_wrong_action_is_refused_and_changes_nothing(action, error, message):
    env = DriveEnv()
    env.reset(seed=3)
    env.step([1.0, 0.5])
    before = env.pose, env.velocity, env.battery, env.seconds
    with pytest.raises(error, match=message):
        env.step(action)
    assert (env.pose, env.velocity, env.battery, env.seconds) == before


def test_actions_beyond_the_limits_count_as_the_limits():
    one, other = DriveEnv(), DriveEnv()
    for env, action in ((one, [7.0, 0.0]), (other, [1.0, 0.0])):
        env.reset(seed=3)
        env.step(action)
    assert one.pose == other.pose


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"rate": 0.5}, ValueError, "rate is 0.5"),
        ({"spec": DISC, "control": "wheels"}, ValueError, "control is 'wheels'"),
        ({"start_pos": (0, 0)}, LayoutError, "start_pos"),
        ({"disturbances": Disturbances(stops=(Stop(0, 1.0, 1.0),))}, ValueError, "stops is"),
        ({"render_mode": "human"}, ValueError, "render_mode is 'human'"),
    ],
)
def test_a_wrong_argument_is_named(arguments, error, message):
    with pytest.raises(error, match=message):
        DriveEnv(**arguments)


def test_steps_need_an_episode():
    env = DriveEnv(max_seconds=0.2)
    with pytest.raises(ResetNeeded):
        env.step([0.0, 0.0])
    env.reset(seed=1)
    env.step([0.0, 0.0])
    assert env.step([0.0, 0.0])[3]
    with pytest.raises(ResetNeeded, match="has ended"):
        env.step([0.0, 0.0])
    with pytest.raises(gymnasium.error.Error, match="seed"):
        env.reset(seed=-1)


def test_an_environment_refuses_copies_with_a_sentence():
    env = DriveEnv()
    for make in (copy.copy, copy.deepcopy, pickle.dumps):
        with pytest.raises(TypeError, match="cannot be copied"):
            make(env)


def test_resets_without_a_seed_continue_the_stream():
    one, other = DriveEnv(), DriveEnv()
    tasks = []
    for env in (one, other):
        env.reset(seed=5)
        drawn = []
        for _ in range(5):
            env.reset()
            drawn.append((env.layout, env.cell))
        tasks.append(drawn)
    assert tasks[0] == tasks[1]
    assert len(set(tasks[0])) == 5


def test_the_observation_is_in_the_frame_of_the_robot():
    env = DriveEnv(Layout(["######", "#P..D#", "######"]), randomize=False, start_pos=(1, 3),
                   observation="dict")  # fmt: skip
    env.reset(seed=1)
    for _ in range(8):
        seen = env.step([0.0, 0.5])[0]
    x, y, heading = env.pose
    assert heading > 0.5
    ahead, right = seen["goal"]
    cos, sin = np.cos(heading), np.sin(heading)
    assert (x + ahead * cos - right * sin, y + ahead * sin + right * cos) == pytest.approx(
        (1.5, 1.5)
    )
    assert seen["heading"] == pytest.approx([cos, sin])
    assert seen["turn_rate"][0] == pytest.approx(env.turn_rate)
    assert seen["time_left"][0] == pytest.approx(400 - 0.8)


def test_a_scan_measures_what_the_physics_backend_measures():
    env, motion = DriveEnv(spec=DISC, rays=24, observation="dict"), RigidBodyMotion()
    seen, _ = env.reset(seed=2)
    motion.reset(env.layout, [env.cell], 2)
    assert seen["scan"] == pytest.approx(motion.scan(0, 24), abs=1e-6)


def test_a_scan_turns_with_the_robot_and_sees_things():
    bare = DriveEnv(rays=8, observation="dict")
    full = DriveEnv(rays=8, observation="dict", on_reset=lambda space: None)
    for env in (bare, full):
        env.reset(seed=4)
    for _ in range(7):
        scans = [env.step([0.1, 0.6])[0]["scan"] for env in (bare, full)]
    assert scans[0] == pytest.approx(scans[1], abs=1e-6)


def test_a_vector_has_the_units_of_the_table():
    one, other = DriveEnv(), DriveEnv(observation="dict")
    vector, seen = one.reset(seed=7)[0], other.reset(seed=7)[0]
    for action in ([1.0, 0.2], [0.5, -0.5]):
        vector, seen = one.step(action)[0], other.step(action)[0]
    units = {"turn_rate": np.pi, "position": 10, "goal": 10, "battery": 18184.88, "time_left": 400,
             "scan": 10}  # fmt: skip
    expected = np.concatenate([seen[name] / units.get(name, 1) for name in seen])
    assert vector == pytest.approx(expected, rel=1e-5)


NAMES = [
    {},
    {"control": "wheels", "rate": 20.0, "rays": 4, "crates": 2},
    {"spec": RobotSpec(mass=70.0), "max_seconds": 33.0, "battery": 900.0},
    {"disturbances": Disturbances(actuation_noise=0.1, slippery={(1, 2), (3, 3)}, grip=0.05)},
    {"disturbances": Disturbances(slippery="all", motor_strength=0.8)},
]


@pytest.mark.parametrize("arguments", NAMES, ids=str)
def test_a_name_makes_the_same_environment_again(arguments):
    env = DriveEnv(**arguments)
    again = DriveEnv.from_name(env.backend)
    assert again.backend == env.backend
    for each in (env, again):
        each.reset(seed=3)
        for _ in range(5):
            each.step([0.7, 0.1])
    assert again.pose == env.pose


def test_a_name_may_limit_an_episode_by_moves():
    env = DriveEnv.from_name("drive", moves=10, units=20)
    assert env.drive_settings.max_seconds == pytest.approx(20.0)
    assert env.drive_settings.battery == pytest.approx(DriveEnv().drive_settings.battery / 10)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("drive:speed=3", "no number is called 'speed'; allowed: .*control, rate"),
        ("drive:mass=heavy", "'mass=heavy' is not of the form"),
        ("drive:control=steer", "control is 'steer'"),
        ("drive:people=1.5", "people is 1.5; it must be a whole number"),
        ("drive:rays=4.5", "rays is 4.5"),
        ("drive:crates=0.5", "crates is 0.5"),
    ],
)
def test_a_wrong_name_is_explained(name, message):
    with pytest.raises(ValueError, match=message):
        DriveEnv.from_name(name)


def test_a_picture_shows_the_robot_where_it_is():
    env = DriveEnv(render_mode="rgb_array")
    env.reset(seed=1)
    before = env.render()
    for _ in range(10):
        env.step([0.5, 0.0])
    after = env.render()
    assert before.shape == (280, 480, 3)
    moved = np.argwhere((before != after).any(axis=2)).mean(axis=0) / 40
    assert np.abs(moved - np.array(env.pose[1::-1])).max() < 0.6
    with pytest.warns(UserWarning, match="render_mode"):
        assert DriveEnv().render() is None


def test_a_picture_shows_crates_pillars_and_bodies_of_users():
    def add(space):
        door = pymunk.Body(5, 1)
        door.position, door.angle = (6.5, 4.5), np.pi / 4
        space.add(door, pymunk.Segment(door, (-0.4, 0), (0.4, 0), 0.1))

    bare, full = (
        DriveEnv(render_mode="rgb_array", randomize=False, **things)
        for things in (
            {},
            {"crates": [(1, 5)], "obstacles": [(8.0, 5.5, 0.4)], "on_reset": add},
        )
    )  # fmt: skip
    for env in (bare, full):
        env.reset(seed=1)
    differs = (bare.render() != full.render()).any(axis=2)
    for x, y, is_shown in (
        (5.5, 1.5, True), (5.7, 1.3, True), (5.5, 1.2, False),  # a crate of half a metre
        (8.0, 5.5, True), (8.35, 5.5, True), (8.3, 5.2, False),  # a pillar
        (6.5, 4.5, True), (6.72, 4.72, True), (6.72, 4.28, False),  # a segment that has turned
    ):  # fmt: skip
        assert differs[int(y * 40), int(x * 40)] == is_shown, (x, y)


def test_options_replace_the_stations_and_the_start():
    env = DriveEnv()
    layout = DEFAULT_LAYOUT.with_stations((1, 1), (5, 10))
    env.reset(seed=1, options={"layout": layout, "start_pos": (3, 3)})
    assert (env.layout, env.cell) == (layout, (3, 3))
    with pytest.raises(ValueError, match="unknown options: 'goal'"):
        env.reset(options={"goal": 1})


@pytest.mark.parametrize("control", ["velocity", "force"])
def test_rows_equal_single_environments(control):
    arguments = {"control": control, "max_seconds": 4.0, "rays": 3}
    rows = DriveVectorEnv(3, autoreset_mode="SameStep", **arguments)
    singles = [DriveEnv(**arguments) for _ in range(3)]
    seen, _ = rows.reset(seed=8)
    expected = [env.reset(seed=8 + row)[0] for row, env in enumerate(singles)]
    assert (seen == expected).all()
    stream, actions = np.random.default_rng(1), np.zeros((3, 2))
    for number in range(90):  # two episodes and a half
        actions = stream.uniform(-1, 1, (3, 2)) if number % 10 == 0 else actions
        seen, rewards, terminated, truncated, info = rows.step(actions)
        for row, env in enumerate(singles):
            observation, reward, ended, cut, own = env.step(actions[row])
            assert (ended, cut) == (terminated[row], truncated[row])
            assert rewards[row] == pytest.approx(reward, abs=1e-9)
            if ended or cut:
                assert info["final_obs"][row] == pytest.approx(observation, abs=1e-5)
                assert info["final_info"]["joules"][row] == pytest.approx(own["joules"])
                observation, _ = env.reset()
            assert seen[row] == pytest.approx(observation, abs=1e-5)


def test_the_next_step_mode_starts_episodes_in_a_step_of_their_own():
    rows = DriveVectorEnv(2, max_seconds=0.2, observation="dict")
    rows.reset(seed=1)
    rows.step(np.zeros((2, 2)))
    *_, truncated, _ = rows.step(np.zeros((2, 2)))
    assert truncated.all()
    seen, rewards, _, truncated, info = rows.step(np.ones((2, 2)))
    assert not truncated.any()
    assert (rewards == 0).all()
    assert (info["joules"] == 0).all()
    assert (seen["velocity"] == 0).all()


def test_the_disabled_mode_waits_for_a_reset_with_a_mask():
    rows = DriveVectorEnv(2, max_seconds=0.2, autoreset_mode="Disabled", observation="dict")
    with pytest.raises(ResetNeeded):
        rows.step(np.zeros((2, 2)))
    mask = np.array([True, False])
    with pytest.raises(ResetNeeded, match="without a mask"):
        rows.reset(options={"reset_mask": mask})
    rows.reset(seed=[1, 2])
    rows.step(np.zeros((2, 2)))
    rows.step(np.zeros((2, 2)))
    with pytest.raises(ResetNeeded, match="2 rows have ended"):
        rows.step(np.zeros((2, 2)))
    rows.reset(options={"reset_mask": mask})
    with pytest.raises(ResetNeeded, match="1 rows have ended, row 1"):
        rows.step(np.zeros((2, 2)))
    rows.reset(options={"reset_mask": ~mask})
    final = DriveVectorEnv(1, max_seconds=0.1, autoreset_mode="SameStep", observation="dict")
    final.reset(seed=1)
    assert set(final.step(np.zeros((1, 2)))[4]["final_obs"][0]) == set(
        final.single_observation_space
    )


def test_more_rows_than_a_space_holds_share_several_spaces():
    rows = DriveVectorEnv(300, rays=0)
    rows.reset(seed=0)
    for _ in range(10):
        rows.step(np.full((300, 2), [0.8, 0.0]))
    single = DriveEnv(rays=0)
    single.reset(seed=299)
    for _ in range(10):
        single.step([0.8, 0.0])
    assert rows.rows.state.positions[299] == pytest.approx(single.pose[:2], abs=1e-9)
