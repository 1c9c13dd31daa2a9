"""A single warehouse as a ``gymnasium.Env``."""

from __future__ import annotations

from copy import deepcopy
from functools import cache
from typing import Any, cast

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray

from warehouse_core.arguments import as_cell, seed_number
from warehouse_core.errors import LayoutError
from warehouse_core.gymnasium_env.sensors import Sensors
from warehouse_core.gymnasium_env.spaces import (
    MARKED,
    RENDER_FPS,
    Extent,
    Limited,
    check_options,
    check_render_mode,
    listed,
    make_form,
)
from warehouse_core.listing import Unlisted
from warehouse_core.motion.backends import Backend, make_motion
from warehouse_core.render.painter import TilePainter, tile_pixels_for
from warehouse_core.render.window import PictureWindow
from warehouse_core.task.encoding import (
    ObservationArrays,
    Window,
    arrays_of,
    marks,
    numbers_of,
    window_of,
)
from warehouse_core.task.rules import useful_actions
from warehouse_core.task.starts import (
    DRAWS,
    Randomized,
    check_room,
    draw_episode,
    has_start,
    motion_seed,
    randomized_parts,
)
from warehouse_core.warehouse_env import WarehouseEnv
from warehouse_core.world.actions import ACTIONS, valid_action
from warehouse_core.world.layout import Layout, check_open
from warehouse_core.world.named_layouts import GivenLayout, as_layout
from warehouse_core.world.tiles import Cell

_Known = tuple[Window, NDArray[np.int32], NDArray[np.int8]]
"""The window, the numbers and the action mask of a cell."""

UNSTARTED = "there has been no reset() yet"
ENDED = "the episode has ended; a reset() must come first"


class WarehouseGymnasiumEnv(Unlisted, Limited, gymnasium.Env[Any, Any]):
    """The environment ``Warehouse-v0``: ``WarehouseEnv`` with the interface of Gymnasium.

    Description:
        A robot takes an item from a pickup to a dropoff, around walls, before its battery is empty.

    Actions:
        ``Discrete(7)``: N, E, S, W, WAIT, PICK, DROP. ``info["action_mask"]``, ``[7]`` int8, is 1
        for each action with an effect.

    Observations:
        The window of the grid around the robot, its cell and load, the battery and steps, and the
        stations, in a form of ``make_form``. Robots with ``Sensors`` also observe their readings.
        After a step ``info["motion"]`` is the ``Outcome`` of the robot.

    Rewards:
        The table in ``task/rules.py``.

    Ends:
        An episode is terminated by the delivery, and truncated when the steps or the battery are
        used up.

    Args:
        layout: a ``Layout``, its rows, its text, its name or the path of its file, see
            ``world/named_layouts.py``; ``None`` is the chapter's layout.
        backend: name, class or instance of a motion; an instance is copied.
        observation: name of the form of observations, see ``make_form``.
        start_pos: start of the robot if it is not random; ``None`` is the default start.
        max_steps: limit of an episode, 1 to ``MAX_STEPS``.
        battery: units of a full charge, 1 to ``MAX_STEPS``; every step costs one unit.
        view_radius: cells seen in each direction, 0 to ``MAX_VIEW_RADIUS``.
        randomize: ``True`` for a random pickup, dropoff and start in each episode, ``"stations"``
            for the first two, or ``"start"`` for the last.
        render_mode: ``"rgb_array"``, ``"ansi"``, ``"human"`` (a window) or ``None``. Without a
            display ``metadata`` does not list ``"human"``.
        tile_pixels: side of a cell in a picture, at least 2; ``None`` fits it to the layout.
        scan: number of rays of a distance scan, which is added to observations, see ``Sensors``; 0
            for no scan. A scan needs a backend with bodies, and the form ``"dict"``.

    Raises:
        ValueError: an argument is not allowed; it may be a ``LayoutError`` or ``BackendError``.
        TypeError: an argument has the wrong type.

    Example:
        >>> import gymnasium
        >>> env = gymnasium.make("warehouse_core.gymnasium_env:Warehouse-v0", layout="trap")
        >>> observation, info = env.reset(seed=1)
        >>> action = env.action_space.sample(info["action_mask"])
        >>> observation, reward, terminated, truncated, info = env.step(action)
    """

    metadata: dict[str, Any] = {  # noqa: RUF012 - declared this way in Gymnasium
        "render_modes": ["human", "rgb_array", "ansi"],
        "render_fps": RENDER_FPS,
    }

    def __init__(
        self,
        layout: GivenLayout | None = None,
        backend: Backend = "grid",
        observation: str = "dict",
        start_pos: Cell | None = None,
        max_steps: int = 200,
        battery: int = 200,
        view_radius: int = 2,
        randomize: bool | str = True,
        render_mode: str | None = None,
        tile_pixels: int | None = None,
        scan: int = 0,
    ) -> None:
        check_render_mode(render_mode, self.metadata["render_modes"])
        self.metadata = listed(self.metadata)
        self._layout = as_layout(layout)
        self._start = None if start_pos is None else as_cell("start_pos", start_pos)
        # Two environments that share a motion would move each other's robots.
        own = backend if isinstance(backend, (str, type)) else deepcopy(make_motion(backend))
        self._warehouse = env = WarehouseEnv(
            self._layout, self._start, max_steps, battery, view_radius, backend=own
        )
        self.max_steps, self._randomized = env.max_steps, randomized_parts(randomize)
        if self._randomized.stations:
            check_room(self._layout)
        extent = Extent(env.height, env.width, env.view_radius, env.max_battery, env.max_steps)
        form = make_form(observation, extent)
        self.observation_space, self._form = form.space, form.of
        self._sensors = Sensors(env, scan, observation)
        if self._sensors.spaces:
            known = cast("spaces.Dict", form.space).spaces
            self.observation_space = spaces.Dict({**known, **self._sensors.spaces})
        self._marked = MARKED.get(observation, ())
        self.action_space = spaces.Discrete(len(ACTIONS))
        self.render_mode = render_mode
        if tile_pixels is None:
            tile_pixels = tile_pixels_for(env.height, env.width)
        self._painter = TilePainter(tile_pixels)
        self._window: PictureWindow | None = None
        self._walls: object = None
        self._forget()
        self._over = UNSTARTED

    @property
    def warehouse(self) -> WarehouseEnv:
        """The wrapped ``WarehouseEnv``."""
        return self._warehouse

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Start an episode.

        Args:
            seed: seed of ``np_random``, which determines pickup, dropoff, start and the seed of
                the motion; ``None`` continues the random stream.
            options: ``randomize``, ``layout`` (of the same size) and ``start_pos`` for this
                episode only.

        Raises:
            ValueError: an option is unknown or its value is not allowed; nothing has changed.
            TypeError: a value has the wrong type; nothing has changed.
            gymnasium.error.Error: the seed is negative or not an integer.
        """
        layout, start, randomized = self._options(
            check_options(options, {"layout", "randomize", "start_pos"})
        )
        try:
            super().reset(seed=seed_number(seed))
        except (TypeError, ValueError) as error:
            raise gymnasium.error.Error(str(error)) from None
        # The count of numbers is fixed, so that later episodes do not depend on the options.
        uniforms = self.np_random.random(DRAWS)
        layout, random_start = draw_episode(layout, uniforms, randomized)
        start = start or random_start
        assert start is not None, "the start is random or given"
        self._warehouse.reset_to(layout, start, motion_seed(uniforms))
        self._forget()
        self._over = ""
        if self.render_mode == "human":
            self._show()
        observation, mask = self._observed()
        return observation, {"action_mask": mask}

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Carry out one action, an integer 0 to 6.

        Raises:
            ValueError: the action is out of range; nothing has changed.
            TypeError: the action is not an integer.
            ResetNeeded: there has been no reset, or the episode has ended.
        """
        index = valid_action(action)
        if self._over:
            raise ResetNeeded(f"step(): {self._over}")
        warehouse = self._warehouse
        reward, terminated, truncated = warehouse.advance(index)
        if terminated or truncated:
            self._over = ENDED
        motion = warehouse.last_motion
        assert motion is not None, "every step has a motion"
        if self.render_mode == "human":
            self._show()
        observation, mask = self._observed()
        info = {"motion": motion.copy(), "action_mask": mask}
        return observation, reward, terminated, truncated, info

    def action_masks(self) -> NDArray[np.int8]:
        """Return the mask ``[7]`` int8: 1 for each action with an effect.

        Raises:
            ResetNeeded: there has been no reset.
        """
        if self._over == UNSTARTED:
            raise ResetNeeded(f"action_masks(): {self._over}")
        return self._look()[1]

    def render(self) -> Any:
        """Return a picture ``[H, W, 3]`` uint8, or the text; windows are updated without it."""
        if self.render_mode == "rgb_array":
            return self._picture()
        if self.render_mode == "ansi":
            return self._warehouse.render()
        if self.render_mode is None:
            gymnasium.logger.warn("render() needs a render_mode, given to gymnasium.make")
        return None

    def close(self) -> None:
        """Close the window and the motion backend."""
        if self._window is not None:
            self._window.close()
            self._window = None
        self._warehouse.close()
        self._over = "the environment has been closed"

    def _options(self, options: dict[str, Any]) -> tuple[Layout, Cell | None, Randomized]:
        """Return the layout, the start (``None`` if it is random) and the random parts."""
        other = options.get("layout")
        layout = self._layout if other is None else as_layout(other)
        if (layout.height, layout.width) != (self._layout.height, self._layout.width):
            raise LayoutError(
                f"the layout has {layout.height} x {layout.width} cells; this environment was "
                f"made for {self._layout.height} x {self._layout.width}"
            )
        randomize = options.get("randomize")
        randomized = self._randomized if randomize is None else randomized_parts(randomize)
        if randomized.stations:
            check_room(layout)
        given = options.get("start_pos")
        if given is None and randomized.start and has_start(layout, randomized):
            return layout, None, randomized
        start = self._start if given is None else as_cell("start_pos", given)
        start = start or layout.default_start()
        check_open(layout, start, "start_pos")
        return layout, start, randomized

    def _forget(self) -> None:
        """Clear the caches by cell, except the cache of open sides if the walls are the same."""
        self._known: dict[tuple[Cell, bool], _Known] = {}
        walls = self._warehouse.layout.open_cells
        if walls is not self._walls:
            self._walls = walls
            self._sides: dict[Cell, tuple[bool, ...]] = {}

    def _observed(self) -> tuple[Any, NDArray[np.int8]]:
        """Return the current observation in its form, and the action mask."""
        arrays, mask = self._look()
        observation = self._form(arrays)
        if self._sensors.spaces:
            observation |= self._sensors.read()
        return observation, mask

    def _look(self) -> tuple[ObservationArrays, NDArray[np.int8]]:
        """Return the current observation as ``encode`` does, and the mask, in new arrays."""
        state = self._warehouse.state
        key = (state.robot_pos, state.has_item)
        known = self._known.get(key)
        if known is None:
            known = self._known[key] = self._encoded(*key)
        window, numbers, mask = known
        numbers = numbers.copy()
        numbers[6], numbers[7] = state.battery, state.steps
        return arrays_of(window.copy(), numbers, state.has_item), mask.copy()

    def _encoded(self, cell: Cell, has_item: bool) -> _Known:
        observation, layout = self._warehouse.observe(), self._warehouse.layout
        sides = self._sides.get(cell)
        if sides is None:
            self._sides[cell] = sides = layout.open_sides(cell)
        mask = _mask(sides, layout.rows[cell[0]][cell[1]], has_item)
        window: Window = window_of(observation)
        if self._marked:
            window = marks(window, self._marked)
        return window, numbers_of(observation), mask

    def _picture(self) -> NDArray[np.uint8]:
        state = self._warehouse.state
        return self._painter.picture(self._warehouse.layout, state.robot_pos, state.has_item)

    def _show(self) -> None:
        self._window = self._window or PictureWindow("Warehouse")
        self._window.show(self._picture(), self.metadata["render_fps"])


@cache
def _mask(open_sides: tuple[bool, ...], tile: str, has_item: bool) -> NDArray[np.int8]:
    return np.array(useful_actions(open_sides, tile, has_item), np.int8)
