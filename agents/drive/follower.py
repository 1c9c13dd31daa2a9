"""A follower: a controller that turns the moves of any grid agent into driving.

The grid agent plays a few moves ahead on the grid, so that the follower knows the next cells. It
steers towards a point on the line through their middles, slows down for corners, and stops at
stations.
"""

from __future__ import annotations

import math
from itertools import pairwise

from warehouse_core import Agent, WarehouseEnv, WarehouseState
from warehouse_core.arguments import instance_of, with_methods
from warehouse_core.motion.base import centre_of
from warehouse_core.world.actions import WAIT, action_index
from warehouse_physics.drive import DriveEnv

KNOWN = 4
"""Moves that are known ahead: enough for the default robot to brake from its top speed."""

AHEAD = 0.5
"""Cells from the robot to the point to steer to. Closer points make robots swing from side to side,
and points further away make them cut corners."""

CORNER, BRAKING, STEERING = 0.5, 0.7, 3.0
"""Share of the top speed at corners, share of the acceleration with which to brake, and turn rate
in rad/s for each radian of error."""

SLOWING = 4
"""Power of the cosine of the error that multiplies the speed, so that a robot turns first."""

LATE, NEAR, LOST = 0.1, 0.1, 0.9
"""Seconds by which a command is late, and two distances in cells. A robot has arrived at less than
``NEAR`` from the end of its line. A robot is lost at more than ``LOST`` from its line."""

Line = list[tuple[float, float]]


class Follower:
    """An agent that drives a ``DriveEnv`` along the moves of a grid agent.

    Example:
        >>> from agents import GreedyAgent
        >>> from agents.drive import Follower
        >>> from warehouse_core import record_episode
        >>> from warehouse_physics.drive import DriveEnv
        >>> env = DriveEnv()
        >>> record_episode(env, Follower(env, GreedyAgent(seed=12)), seed=12).outcome
        'delivered'
    """

    def __init__(self, env: DriveEnv, agent: Agent) -> None:
        self.env = instance_of("env", env, DriveEnv)
        self._agent, self.reason = with_methods("agent", agent, "reset", "act"), ""
        self._grid = WarehouseEnv(env.layout)
        self._line: Line = [(0.0, 0.0)] * 2
        self._task, self._due, self._size = False, math.inf, env.robot_spec.cell_size

    def reset(self) -> None:
        """Forget the last episode."""
        self._agent.reset()
        self._start_again()

    def act(self, observation: object) -> tuple[float, float]:
        """Return the next action; the state of the robot is read from the environment."""
        spec, size = self.env.robot_spec, self.env.robot_spec.cell_size
        here = self.env.pose[:2]
        self._plan()
        while len(self._line) > 2 and _along(self._line, here) >= math.dist(*self._line[:2]):
            del self._line[0]
        along = _along(self._line, here)
        if math.dist(here, _walk(self._line, along)) > LOST * size:
            self._start_again()
            return 0.0, 0.0
        left = sum(math.dist(*leg) for leg in pairwise(self._line)) - along
        self._finish_task(left < NEAR * size)
        braking = 2 * BRAKING * spec.acceleration
        coming = LATE * math.hypot(*self.env.velocity)
        stop = math.sqrt(braking * max(left - coming, 0.0))
        corner = max(_corner(self._line) - along - AHEAD * size - coming, 0.0)
        speed = min(stop, math.hypot(CORNER * spec.top_speed, math.sqrt(braking * corner)))
        return self._steer(_walk(self._line, along + AHEAD * size), speed / spec.top_speed)

    def _steer(self, aim: tuple[float, float], speed: float) -> tuple[float, float]:
        """Return the action that drives towards a point with a share of the top speed."""
        spec, (x, y, heading) = self.env.robot_spec, self.env.pose
        right, down = aim[0] - x, aim[1] - y
        distance, speed = math.hypot(right, down), min(speed, 1.0)
        if not spec.is_differential:
            share = speed / distance if distance else 0.0
            return share * right, share * down
        coming = heading + LATE * self.env.turn_rate
        error = math.remainder(math.atan2(down, right) - coming, math.tau)
        if distance < NEAR * spec.cell_size:
            return speed * math.cos(error), 0.0
        # The wheels need time to stop a turn, and half of their force is for driving.
        slowing = math.sqrt(BRAKING * spec.acceleration / spec.wheel_arm * abs(error))
        turn = math.copysign(min(STEERING * abs(error), slowing), error)
        return speed * max(math.cos(error), 0.0) ** SLOWING, turn * spec.wheel_arm / spec.top_speed

    def _plan(self) -> None:
        """Let the grid agent play ahead until its next stop, or until enough moves are known."""
        for _ in range(2 * KNOWN):  # an agent may bump into walls
            if self._task or len(self._line) > KNOWN:
                return
            before = self._grid.state.robot_pos
            index = action_index(self._agent.act(self._grid.observe()))
            self.reason = str(getattr(self._agent, "reason", ""))
            self._grid.advance(index)
            self._task = index >= WAIT
            if self._grid.state.robot_pos != before:
                self._line.append(centre_of(self._grid.state.robot_pos, self._size))

    def _finish_task(self, has_arrived: bool) -> None:
        """Go on after a stop, once the robot has stood long enough to pick, drop or wait."""
        env = self.env
        if self._task and has_arrived:
            self._due = min(self._due, env.seconds + env.robot_spec.dwell)
        if env.seconds < self._due:
            return
        if env.has_item == self._grid.state.has_item:
            self._task, self._due = False, math.inf
        elif env.seconds > self._due + env.robot_spec.dwell:
            self._start_again()

    def _start_again(self) -> None:
        """Put the grid agent into the present cell of the robot."""
        env, seen = self.env, self.env.observe()
        self._task, self._due = False, math.inf
        self._grid = WarehouseEnv(env.layout, env.cell)
        state = WarehouseState(env.cell, env.has_item, seen["battery"], seen["steps"])
        self._grid.state = state
        here, centre = env.pose[:2], centre_of(env.cell, self._size)
        # A robot in the middle may leave in any direction, so its line begins there.
        is_near = math.dist(here, centre) < NEAR * self._size
        self._line = [centre if is_near else here, centre]


def _along(line: Line, here: tuple[float, float]) -> float:
    """Return how many metres of the first leg of a line lie behind a position."""
    (x, y), (to_x, to_y) = line[:2]
    length = math.hypot(to_x - x, to_y - y)
    inside = (here[0] - x) * (to_x - x) + (here[1] - y) * (to_y - y)
    return max(inside / length, 0.0) if length else 0.0


def _walk(line: Line, metres: float) -> tuple[float, float]:
    """Return the point of a line after some metres, at most its end."""
    for (x, y), (to_x, to_y) in pairwise(line):
        length = math.hypot(to_x - x, to_y - y)
        if metres < length:
            share = metres / length
            return x + share * (to_x - x), y + share * (to_y - y)
        metres -= length
    return line[-1]


def _corner(line: Line) -> float:
    """Return the metres from the start of a line to its first corner, or infinity."""
    metres = 0.0
    for (ax, ay), (bx, by), (cx, cy) in zip(line, line[1:], line[2:], strict=False):
        metres += math.hypot(bx - ax, by - ay)
        if abs((bx - ax) * (cy - by) - (by - ay) * (cx - bx)) > 1e-6 or (
            (bx - ax) * (cx - bx) + (by - ay) * (cy - by) < 0
        ):
            return metres
    return math.inf
