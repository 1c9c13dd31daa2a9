"""A fleet as a ``pettingzoo.ParallelEnv``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray
from pettingzoo import ParallelEnv

from warehouse_core.errors import EndedError
from warehouse_core.fleet.env import FleetEnv
from warehouse_core.gymnasium_env.spaces import RENDER_FPS, Extent, check_render_mode, listed
from warehouse_core.listing import Unlisted
from warehouse_core.pettingzoo_env.spaces import make_fleet_form, state_of, state_space
from warehouse_core.render.painter import TilePainter, tile_pixels_for
from warehouse_core.render.window import PictureWindow
from warehouse_core.task.encoding import FleetArrays
from warehouse_core.wording import brief
from warehouse_core.world.actions import valid_action
from warehouse_core.world.named_layouts import GivenLayout, as_layout
from warehouse_core.world.tiles import PERSON, ROBOT_EMPTY, ROBOT_LOADED

Dicts = tuple[dict[str, Any], dict[str, dict[str, Any]]]
"""Observations and infos by agent."""

ParallelStep = tuple[
    dict[str, Any], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]
]


class WarehouseParallelEnv(Unlisted, ParallelEnv[str, Any, int]):
    """``FleetEnv`` with the interface of PettingZoo and the agents ``robot_0``, ``robot_1``, ...

    Description:
        ``R`` robots move items from pickups to dropoffs with the rules of ``FleetEnv``.

    Actions:
        ``Discrete(7)`` for each robot: N, E, S, W, WAIT, PICK, DROP. ``info["action_mask"]``,
        ``[7]`` int8, is 1 for each action with an effect. With ``moves="turn"`` the space is
        ``Discrete(6)``: FORWARD, RIGHT, LEFT, WAIT, PICK, DROP.

    Observations:
        With ``"dict"`` a flat ``Dict`` with the keys of ``FleetArrays`` and ``action_mask``. With
        ``"vector"`` a ``Box``, see ``encoding.vector``, with ``FLEET_TILES``. With ``"image"`` a
        picture without headings, see ``render/observation_image.py``. The arrays of
        different calls share no memory. ``state()`` describes all robots and open orders.

    Rewards:
        The same as in ``FleetEnv``.

    Ends:
        The same as in ``FleetEnv``. A robot that has ended leaves ``agents``, but stays in its cell
        and blocks others.

    Args:
        layout: a layout in a form that ``WarehouseGymnasiumEnv`` accepts.
        robots: number of robots ``R``, which are the ``possible_agents``.
        max_cycles: limit of an episode in steps.
        observation: ``"dict"``, ``"vector"`` or ``"image"``.
        render_mode: ``"rgb_array"``, ``"ansi"``, ``"human"`` (a window) or ``None``. Without a
            display ``metadata`` does not list ``"human"``.
        tile_pixels: side of a cell in a picture, at least 2; ``None`` fits it to the layout.
        max_steps: another name of ``max_cycles``, as in ``FleetEnv``.
        settings: other arguments of ``FleetEnv``, such as ``orders``.

    Raises:
        ValueError: an argument is not allowed; it may be a ``LayoutError``, ``OrderError`` or
            ``BackendError``.
        TypeError: an argument has the wrong type.

    Example:
        >>> from warehouse_core.pettingzoo_env import parallel_env
        >>> parallel = parallel_env(robots=2, orders=0.1)
        >>> observations, infos = parallel.reset(seed=1)
        >>> observations, rewards, *ends, infos = parallel.step({"robot_0": 1, "robot_1": 1})
        >>> rewards
        {'robot_0': -0.1, 'robot_1': -0.1}
    """

    metadata: dict[str, Any] = {  # noqa: RUF012 - declared this way in PettingZoo
        "name": "warehouse_v0",
        "render_modes": ["human", "rgb_array", "ansi"],
        "render_fps": RENDER_FPS,
        "is_parallelizable": True,
    }

    def __init__(
        self,
        layout: GivenLayout | None = None,
        robots: int = 2,
        max_cycles: int = 200,
        observation: str = "dict",
        render_mode: str | None = None,
        tile_pixels: int | None = None,
        *,
        max_steps: int | None = None,
        **settings: Any,
    ) -> None:
        check_render_mode(render_mode, self.metadata["render_modes"])
        self.metadata = listed(self.metadata)
        limit = max_cycles if max_steps is None else max_steps
        self.fleet = fleet = FleetEnv(as_layout(layout), robots, max_steps=limit, **settings)
        height, width = fleet.layout.height, fleet.layout.width
        capacity, radius = fleet.settings.battery.capacity, fleet.settings.view_radius
        extent = Extent(height, width, radius, capacity, fleet.settings.max_steps)
        self._space, self._form = make_fleet_form(observation, extent, fleet)
        self._has_masks = observation == "dict"
        self.possible_agents = [f"robot_{robot}" for robot in range(fleet.settings.robots)]
        count = len(fleet.settings.actions)
        self._actions = {agent: spaces.Discrete(count) for agent in self.possible_agents}
        self.state_space = state_space(extent, fleet)
        self.agents: list[str] = []
        self._rows: list[int] = []
        self.render_mode = render_mode
        pixels = tile_pixels_for(height, width) if tile_pixels is None else tile_pixels
        self._painter = TilePainter(pixels)
        self._window: PictureWindow | None = None

    def observation_space(self, agent: str) -> gymnasium.Space[Any]:
        """Return the observation space, which is the same for all robots."""
        return self._space

    def action_space(self, agent: str) -> gymnasium.Space[Any]:
        """Return the action space of a robot, which has a random stream of its own."""
        if not isinstance(agent, str) or agent not in self._actions:
            raise ValueError(f"agent is {brief(agent)}; allowed: {', '.join(self._actions)}")
        return self._actions[agent]

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> Dicts:
        """Start an episode with all robots.

        Args:
            seed: seed for ``FleetEnv.reset``.
            options: not used.

        Returns:
            Observations and infos by agent, see the class.

        Raises:
            ValueError: the seed is negative; nothing has changed.
            TypeError: the seed is not an integer.
        """
        arrays, info = self.fleet.reset(seed)
        self.agents = self.possible_agents.copy()
        self._rows = list(range(len(self.agents)))
        if self.render_mode == "human":
            self._show()
        return self._dicts(arrays, info["action_mask"])

    def step(self, actions: Mapping[str, int]) -> ParallelStep:
        """Carry out one action, an integer, for each of ``agents``.

        Returns:
            Observations, rewards, terminated, truncated and infos by agent. When all agents have
            ended, a step without actions changes nothing and returns five empty dictionaries.

        Raises:
            ValueError: an action is out of range or belongs to another robot, or one of ``agents``
                has no action; nothing has changed.
            TypeError: ``actions`` is not a mapping, or an action is not an integer.
            EndedError: there is no episode yet, or all robots have ended.
        """
        if not isinstance(actions, Mapping):
            raise TypeError(f"actions is {brief(actions)}; it must be a mapping from agents")
        if not self.agents and not actions and self.fleet.steps:
            return {}, {}, {}, {}, {}
        chosen = self._chosen(actions)
        arrays, *results, info = self.fleet.step(chosen)
        observations, infos = self._dicts(arrays, info["action_mask"])
        rewards, terminated, truncated = (self._by_agent(values.tolist()) for values in results)
        if True in terminated.values() or True in truncated.values():
            self._rows = [row for row, ended in enumerate(self.fleet.ended) if not ended]
            self.agents = [self.possible_agents[row] for row in self._rows]
        if self.render_mode == "human":
            self._show()
        return observations, rewards, terminated, truncated, infos

    def state(self) -> NDArray[np.float32]:
        """Return a new vector of all robots and the oldest open orders; see ``spaces.state_of``.

        Raises:
            EndedError: there is no episode yet.
        """
        return state_of(self.fleet)

    def render(self) -> Any:
        """Return a picture ``[H, W, 3]`` uint8, or the text; windows are updated without it."""
        if self.render_mode == "rgb_array":
            return self._picture()
        if self.render_mode == "ansi":
            return self._text()
        if self.render_mode is None:
            gymnasium.logger.warn("render() needs a render_mode, given to parallel_env")
        return None

    def close(self) -> None:
        """Close the window and the motion backend."""
        if self._window is not None:
            self._window.close()
            self._window = None
        self.fleet.close()

    def _chosen(self, actions: Mapping[str, int]) -> NDArray[np.intp]:
        """Return the checked actions of all robots; robots that have ended wait."""
        if not self.agents:
            raise EndedError("step() needs a reset() before it: there are no agents")
        if actions.keys() != set(self.agents):
            odd = sorted(actions.keys() ^ set(self.agents), key=str)[0]
            problem = "an action for" if odd in actions else "no action for"
            raise ValueError(f"{problem} {odd}; needed: one for each of agents and no other")
        allowed = self.fleet.settings.actions
        chosen = [allowed.wait] * len(self.possible_agents)
        for row, agent in zip(self._rows, self.agents, strict=True):
            chosen[row] = valid_action(actions[agent], len(allowed))
        return np.array(chosen, np.intp)

    def _dicts(self, arrays: FleetArrays, masks: NDArray[np.int8]) -> Dicts:
        """Return the observations and infos of ``agents``."""
        form: Any = self._form(arrays)
        observed, masked = form, list(masks)
        if self._has_masks:
            columns = {**form, "action_mask": masked}
            columns |= {
                name: form[name].tolist() for name in ("has_item", "heading") if name in form
            }
            rows = zip(*columns.values(), strict=True)
            observed = [dict(zip(columns, row, strict=True)) for row in rows]
        infos = self._by_agent([{"action_mask": mask} for mask in masked])
        return self._by_agent(observed), infos

    def _by_agent(self, values: Sequence[Any]) -> dict[str, Any]:
        """Return the values of ``agents`` by name, given the values ``[R]`` of all robots."""
        return {agent: values[row] for agent, row in zip(self.agents, self._rows, strict=True)}

    def _picture(self) -> NDArray[np.uint8]:
        fleet = self.fleet
        robots = zip(fleet.cells, fleet.loaded, strict=True)
        return self._painter.fleet_picture(fleet.layout, robots, fleet.people, fleet.headings)

    def _text(self) -> str:
        """Return the layout as text, with robots and people on top."""
        frame = [list(row) for row in self.fleet.layout.rows]
        for (row, col), has_item in zip(self.fleet.cells, self.fleet.loaded, strict=True):
            frame[row][col] = ROBOT_LOADED if has_item else ROBOT_EMPTY
        for row, col in self.fleet.people:
            frame[row][col] = PERSON
        return "\n".join(map("".join, frame))

    def _show(self) -> None:
        self._window = self._window or PictureWindow("Warehouse")
        self._window.show(self._picture(), self.metadata["render_fps"])
