"""Crates, obstacles and bodies of users."""

import itertools
import sys

import numpy as np
import pymunk
import pytest

from warehouse_core import (
    DEFAULT_LAYOUT,
    Episode,
    Layout,
    LayoutError,
    record_episode,
    replay_episode,
)
from warehouse_core.errors import BackendError
from warehouse_core.viz.tracks.record_track import step_captions
from warehouse_physics import RobotSpec
from warehouse_physics.drive import DriveEnv
from warehouse_physics.drive.recording import DriveRecorder
from warehouse_physics.drive.things import CRATE_MASS

AISLE = Layout(["##########", "#P......D#", "##########"])


def crate_of(env):
    [crate] = [body for body in env.space.bodies if body.mass == CRATE_MASS]
    return crate


def on_aisle(**others):
    env = DriveEnv(AISLE, spec=RobotSpec(), randomize=False, start_pos=(1, 2), rays=4, **others)
    env.reset(seed=1)
    return env


def test_a_free_crate_moves_and_a_crate_against_a_wall_blocks():
    env = on_aisle(crates=[(1, 4)])
    crate = crate_of(env)
    for _ in range(300):
        env.step([1.0, 0.0])
    assert crate.position.x == pytest.approx(8.75, abs=0.02)  # its side is half a cell
    assert env.pose[0] == pytest.approx(8.5 - 0.35, abs=0.02)
    assert np.hypot(*env.velocity) < 1e-3


def test_a_hit_with_a_crate_moves_momentum_from_the_robot_to_the_crate():
    env = on_aisle(crates=[(1, 5)])
    crate, robot, pushes = crate_of(env), env.robot, []

    def note(arbiter, space, data):
        pushes.append(arbiter.total_impulse.x)

    env.space.on_collision(1, 0, post_solve=note)
    floor = 0.2 * CRATE_MASS * 9.81 * env.robot_spec.time_step
    while crate.position.x < 6:
        before, count = crate.velocity.x, len(pushes)
        x_before = crate.position.x
        env.step([1.0, 0.0])
        if len(pushes) > count + 5 and crate.position.x > x_before + 0.01:
            gained = CRATE_MASS * (crate.velocity.x - before)
            given = sum(map(abs, pushes[count:])) - 6 * floor
            assert gained == pytest.approx(given, rel=0.01, abs=0.02)
    hits = [c for c in env.last_motion.contacts if c.counterpart == "crate 0"]
    assert robot.velocity.x > 0.1
    assert all(hit.impulse > 0 for hit in hits)


def test_the_first_hit_is_the_speed_times_the_reduced_mass():
    env = on_aisle(crates=[(1, 5)])
    while not (env.last_motion and env.last_motion.contacts):
        speed = env.velocity[0]
        env.step([1.0, 0.0])
    hit = env.last_motion.contacts[0]
    reduced = 50 * CRATE_MASS / (50 + CRATE_MASS)
    assert hit.counterpart == "crate 0"
    assert hit.impulse == pytest.approx(speed * reduced, rel=0.05)


def test_random_crates_leave_a_path_and_depend_on_the_seed():
    env, places = DriveEnv(crates=5), []
    for seed in (1, 1, 2):
        env.reset(seed=seed)
        crates = [body for body in env.space.bodies if body.mass == CRATE_MASS]
        places.append([(int(each.position.y), int(each.position.x)) for each in crates])
        rows = [list(row) for row in env.layout.rows]
        for row, col in places[-1]:
            rows[row][col] = "#"
        blocked = Layout(["".join(row) for row in rows])
        assert blocked.reachable_from(env.cell) >= {*env.layout.pickups, *env.layout.dropoffs}
    assert places[0] == places[1] != places[2]


def test_crates_need_room():
    with pytest.raises(LayoutError, match="only 0 fit without blocking"):
        DriveEnv(AISLE, crates=3, randomize=False, start_pos=(1, 2)).reset(seed=1)
    with pytest.raises(LayoutError, match="start of the robot"):
        on_aisle(crates=[(1, 2)])
    with pytest.raises(LayoutError, match="crates"):
        on_aisle(crates=[(0, 0)])


def test_a_robot_stops_at_a_pillar_and_at_a_polygon_and_sees_them():
    for obstacle, edge in (((5.0, 1.5, 0.2), 4.8), ([(5, 1), (6, 1), (6, 2), (5, 2)], 5.0)):
        env = on_aisle(obstacles=[obstacle], observation="dict")
        assert env.step([0.0, 0.0])[0]["scan"][0] == pytest.approx(edge - 2.5, abs=1e-3)
        for _ in range(60):
            env.step([1.0, 0.0])
        assert env.pose[0] == pytest.approx(edge - 0.35, abs=0.01)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"obstacles": [(1, 2)]}, "obstacles has"),
        ({"obstacles": [(1.0, 2.0, -1.0)]}, "obstacle is -1.0"),
        ({"obstacles": [[(1, 1), (2, 2)]]}, "at least 3 corners"),
        ({"obstacles": [7]}, "obstacles has 7"),
        ({"on_reset": 3}, "on_reset is 3"),
        ({"crates": -1}, "crates is -1"),
        ({"crates": 999}, "crates is 999"),
        ({"people": 1.5}, "people is 1.5"),
        ({"crates": [(1, 2, 3)]}, "it must be a number, or cells"),
        ({"obstacles": 7}, "obstacles is 7"),
    ],
)
def test_wrong_things_are_named(arguments, message):
    with pytest.raises((TypeError, ValueError), match=message):
        DriveEnv(**arguments)


def test_a_trailer_from_a_hook_is_there_after_each_reset():
    def add(space):
        robot = next(iter(space.bodies))
        trailer = pymunk.Body(10, 1)
        trailer.position = robot.position - (0.7, 0)
        space.add(trailer, pymunk.Circle(trailer, 0.2))
        space.add(pymunk.PinJoint(robot, trailer))

    env = DriveEnv(AISLE, spec=RobotSpec(), on_reset=add, randomize=False, start_pos=(1, 3))
    ends = []
    for _ in range(2):
        env.reset(seed=1)
        for _ in range(30):
            env.step([1.0, 0.0])
        assert len(env.space.bodies) == 2
        ends.append((env.pose, tuple([*env.space.bodies][1].position)))
    assert ends[0] == ends[1]
    assert ends[0][1][0] == pytest.approx(env.pose[0] - 0.7, abs=0.02)


def test_a_body_that_was_added_by_hand_survives_a_reset():
    env = on_aisle()
    ball = pymunk.Body(3, 1)
    ball.position = 6.5, 1.5
    door = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
    env.space.add(ball, pymunk.Circle(ball, 0.2), door, pymunk.PinJoint(env.robot, ball))
    env.space.add(pymunk.Circle(env.space.static_body, 0.1, (8, 1.5)))
    with pytest.raises(LayoutError):
        env.reset(seed=2, options={"start_pos": (0, 0)})
    assert ball in env.space.bodies  # nothing has changed
    env.reset(seed=2)
    assert ball in env.space.bodies
    assert door in env.space.bodies
    assert len(env.space.constraints) == 0  # the joint to the former robot is gone
    for _ in range(60):
        env.step([1.0, 0.0])
    assert ball.position.x > 7


def test_a_callback_of_a_user_is_called_beside_ours():
    calls = []
    env = on_aisle(on_reset=lambda space: space.on_collision(
        1, 2, begin=lambda arbiter, space, data: calls.append(arbiter.normal)))  # fmt: skip
    for _ in range(40):
        env.step([-1.0, 0.0])
    assert calls
    assert env.pose[0] == pytest.approx(1.35, abs=0.01)


def test_sensors_are_neither_hit_nor_seen():
    def add(space):
        zone = pymunk.Circle(space.static_body, 0.3, (5.0, 1.5))
        zone.sensor = True
        space.add(zone)

    env = on_aisle(on_reset=add, observation="dict")
    assert env.step([0.0, 0.0])[0]["scan"][0] == pytest.approx(6.5)
    for _ in range(40):
        env.step([1.0, 0.0])
        assert not env.last_motion.contacts
    assert env.pose[0] > 5.5


class Ahead:
    """An agent that drives straight on."""

    reason = "straight on"

    def reset(self):
        """Forget nothing."""

    def act(self, observation):
        """Drive."""
        assert observation.shape == (29,)
        return 0.8, 0.1


def walk_of(seconds, **arguments):
    """Return the cells of the people in each tenth of a second, and the contacts of the robot."""
    env = DriveEnv(rays=0, max_seconds=1_000.0, randomize=False, **arguments)
    env.reset(seed=arguments.pop("seed", 1))
    people = [body for body in env.space.bodies if body is not env.robot]
    cells, contacts = [], []
    for _ in range(10 * seconds):
        env.step([0.0, 0.0])
        cells.append([(int(body.position.y), int(body.position.x)) for body in people])
        contacts += env.last_motion.contacts
    return env, cells, contacts


def test_people_walk_on_at_random_over_open_cells():
    env, cells, _ = walk_of(40, people=2)
    for one in zip(*cells, strict=True):
        assert all(env.layout.is_open(cell) for cell in one)
        assert len(set(one)) > 10
        turns = [cell for cell, after in itertools.pairwise(one) if cell != after]
        back = sum(first == third for first, third in zip(turns, turns[2:], strict=False))
        assert back < len(turns) / 4
    assert walk_of(5, people=2)[1] == cells[:50]


def test_people_stop_for_a_robot_and_turn_back():
    _, cells, contacts = walk_of(30, people=1, layout=AISLE, start_pos=(1, 4))
    sides = {cell[0][1] < 4 for cell in cells}
    assert not contacts
    assert len(sides) == 1
    assert len({cell[0] for cell in cells}) >= 2
    met = walk_of(1, people=0, layout=AISLE, start_pos=(1, 4))[0]
    assert met.robot.position.x == 4.5


def test_a_person_who_was_pushed_into_another_cell_walks_away():
    env = DriveEnv(AISLE, spec=RobotSpec(), people=1, rays=0, randomize=False, start_pos=(1, 1))
    env.reset(seed=1)
    [person] = [body for body in env.space.bodies if body is not env.robot]
    env.step([0.0, 0.0])
    env.robot.position = person.position - (0.7, 0)
    person.position += (1.2, 0)  # both of its cells are now behind the robot
    env.robot.position += (1.2, 0)
    before, places = person.position.x, []
    for _ in range(200):
        env.step([0.0, 0.0])
        places.append(person.position.x)
    assert max(places) - before > 1


def test_a_robot_that_drives_into_a_person_hits_it():
    env = on_aisle(people=1)
    contacts = []
    for _ in range(200):
        env.step([1.0, 0.0])
        contacts += env.last_motion.contacts
    assert contacts[0].counterpart == "person 0"
    assert 0 < contacts[0].impulse <= 40 * 1.6


def test_people_need_room_and_an_open_cell():
    with pytest.raises(LayoutError, match="people is 8; only 5 fit"):
        on_aisle(people=8)
    alone = Layout(["#####", "#P#.#", "#D#.#", "##.##", "#####"])
    env = DriveEnv(alone, people=1, randomize=False, start_pos=(1, 1))
    env.reset(seed=3)
    for _ in range(50):
        env.step([0.0, 0.0])
    [person] = [body for body in env.space.bodies if body is not env.robot]
    assert env.layout.is_open((int(person.position.y), int(person.position.x)))


def test_a_motion_has_the_rays_and_the_outlines_of_things():
    def hang(space):
        bar = pymunk.Segment(space.static_body, (7.2, 1.1), (7.2, 1.9), 0.05)
        space.add(bar)

    env = on_aisle(crates=[(1, 5)], obstacles=[(4.0, 1.5, 0.1)], on_reset=hang)
    env.step([0.0, 0.0])
    lines = env.last_motion.lines
    assert lines[:, 0].tolist() == [1] * 4 + [0] * (4 + 18 + 1)
    ahead, right, back, left = lines[:4, 3:]
    assert [*ahead, *right, *back, *left] == pytest.approx(
        [3.9, 1.5, 2.5, 2.0, 1.0, 1.5, 2.5, 1.0], abs=2e-3
    )
    crate, pillar = lines[4:8, 1:], lines[8:26, 1:]
    assert {tuple(corner) for corner in crate[:, :2].round(2).tolist()} == {
        (5.25, 1.25), (5.75, 1.25), (5.25, 1.75), (5.75, 1.75),
    }  # fmt: skip
    assert np.hypot(*(pillar[:, :2] - (4.0, 1.5)).T) == pytest.approx(0.1)
    assert lines[26, 1:].tolist() == [7.2, 1.1, 7.2, 1.9]


@pytest.mark.parametrize("things", [{"crates": 3}, {"people": 2}])
def test_a_record_is_replayed_bit_for_bit(tmp_path, things):
    env = DriveEnv(max_seconds=6.0, **things)
    episode = record_episode(env, Ahead(), seed=4)
    assert (episode.agent, episode.seed, episode.steps) == ("Ahead", 4, 60)
    assert episode.reasons[0] == "straight on"
    assert DriveRecorder(env, seed=4).place == "step 1"
    episode.save(tmp_path / "drive.npz")
    loaded = Episode.load(tmp_path / "drive.npz")
    assert loaded == episode
    assert replay_episode(loaded) == episode
    again = replay_episode(loaded, backend=DriveEnv(max_seconds=6.0, rays=5, **things))
    assert again.cells == episode.cells


def test_a_record_with_things_of_its_own_needs_the_environment():
    def make():
        return DriveEnv(DEFAULT_LAYOUT, obstacles=[(5.0, 5.0, 0.2)], max_seconds=2.0)

    episode = record_episode(make(), Ahead(), seed=4)
    with pytest.raises(BackendError, match="backend=env"):
        replay_episode(episode)
    assert replay_episode(episode, backend=make()) == episode


def test_a_record_says_what_its_replay_needs(monkeypatch):
    episode = record_episode(DriveEnv(max_seconds=0.3), Ahead(), seed=4)
    monkeypatch.setitem(sys.modules, "warehouse_physics.drive.replay", None)
    with pytest.raises(BackendError, match=r"needs .*, which is not installed: pip install"):
        replay_episode(episode)


def test_a_damaged_action_is_named():
    episode = record_episode(DriveEnv(max_seconds=0.5), Ahead(), seed=4)
    episode.actions[2] = "E"
    captions = step_captions(episode)
    assert (captions[1], captions[2]) == ("Command 0.80, 0.10: straight on", "E: straight on")
    with pytest.raises(ValueError, match="the action is 'E'; it must be two numbers"):
        replay_episode(episode)


def test_the_stations_of_a_record_are_those_of_the_environment():
    env = DriveEnv(max_seconds=0.3, randomize=False)
    episode = record_episode(env, Ahead(), seed=1)
    assert episode.layout == DEFAULT_LAYOUT
    with pytest.raises(ValueError, match="randomize is 'start'"):
        record_episode(env, Ahead(), seed=1, randomize="start")
