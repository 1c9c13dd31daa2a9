"""The warehouse as Gymnasium knows environments: ``Warehouse-v0``, one at a time or a batch.

``gymnasium.make("warehouse_core.gymnasium_env:Warehouse-v0", backend="physics")`` imports this
module, which registers the name. Nothing else in this package imports Gymnasium, and no rule is
here: ``WarehouseEnv`` and ``BatchEnv`` do the work, and this file makes spaces and info of it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import deepcopy
from typing import Any, NamedTuple, TypeGuard, cast

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.error import ResetNeeded
from gymnasium.vector.utils import batch_space, iterate
from numpy.typing import ArrayLike, NDArray

from warehouse_core.action_masks import ActionMasks
from warehouse_core.arguments import as_cell, as_flag, whole_number
from warehouse_core.backends import Backend
from warehouse_core.batch_env import NEXT_STEP, BatchEnv, EndedError, Seeds
from warehouse_core.encoding import MOST_STEPS, Arrays, Encoder, vector, vector_limits
from warehouse_core.layout import Cell, GivenLayout, Layout, LayoutError, as_layout
from warehouse_core.observation_image import ObservationImage
from warehouse_core.picture_window import PictureWindow
from warehouse_core.rules import ACTIONS, valid_action
from warehouse_core.sight import CELL_CODES
from warehouse_core.station_draw import DRAWS, NEEDED, check_room, draw_stations, motion_seed
from warehouse_core.tile_painter import TilePainter, tile_pixels_for
from warehouse_core.warehouse_env import WarehouseEnv, check_start

ID = "Warehouse-v0"
FORMS = ("dict", "vector", "image")
RENDER_FPS = 8

UNSTARTED = "there has been no reset() yet"

MOST_VIEW_RADIUS = 500
"""A window of a million cells; no space need be larger."""

LEAST = 2
"""Rows and columns that spaces have room for: Gymnasium warns of bounds that leave no choice."""

AutoresetMode: Any = getattr(gymnasium.vector, "AutoresetMode", str)
"""Gymnasium's own enumeration; version 1.0 had none, and its name has to do."""


class Form(NamedTuple):
    """One way to give observations: their space, and what makes them of arrays."""

    space: spaces.Space[Any]
    of: Callable[[Arrays], Any]


class Extent(NamedTuple):
    """What bounds every value of an observation."""

    height: int
    width: int
    view_radius: int
    battery: int
    max_steps: int


def make_form(name: str, extent: Extent) -> Form:
    """Return a form of observation by its name.

    ============  =================================================================================
    ``"dict"``    a flat ``Dict`` with the keys of the chapter's observation, as ``Arrays`` in
                  ``encoding.py`` says; a pickup or dropoff that does not exist is ``(-1, -1)``
    ``"vector"``  a ``Box`` of one dimension, as ``encoding.vector`` says
    ``"image"``   a ``Box`` of uint8 ``[8 (H + 1), 8 W, 3]``, as ``observation_image.py`` says
    ============  =================================================================================

    Raises:
        ValueError: no form is called so, a battery or steps above ``MOST_STEPS``, or a view radius
            above ``MOST_VIEW_RADIUS``.
    """
    height, width, view_radius, battery, max_steps = extent
    whole_number("battery", battery, 1, MOST_STEPS)
    whole_number("max_steps", max_steps, 1, MOST_STEPS)
    whole_number("view_radius", view_radius, 0, MOST_VIEW_RADIUS)
    if name == "dict":
        return Form(_dict_space(extent), _as_it_is)
    if name == "vector":
        rows, columns = max(height, LEAST), max(width, LEAST)
        low, high = vector_limits(rows, columns, view_radius, battery, max_steps)
        return Form(spaces.Box(low, high, dtype=np.float32), vector)
    if name == "image":
        image = ObservationImage(height, width, battery, max_steps)
        return Form(spaces.Box(0, 255, image.shape, np.uint8), image.paint)
    raise ValueError(f"observation is {name!r}; allowed: {', '.join(FORMS)}")


def _as_it_is(arrays: Arrays) -> Arrays:
    return arrays  # a lambda could not be pickled


def _dict_space(extent: Extent) -> spaces.Dict:
    last_cell = np.maximum([extent.height, extent.width], LEAST) - 1
    window = (2 * extent.view_radius + 1) ** 2

    def whole(low: int, high: ArrayLike, size: int) -> spaces.Box[Any]:
        highest = np.broadcast_to(np.asarray(high, np.int32), (size,))
        return spaces.Box(np.full(size, low, np.int32), highest, dtype=np.int32)

    return spaces.Dict(
        {
            "local_grid": spaces.Box(0, max(CELL_CODES.values()), (window,), np.uint8),
            "robot_pos": whole(0, last_cell, 2),
            "has_item": spaces.Discrete(2),
            "battery": whole(0, extent.battery, 1),
            "steps": whole(0, extent.max_steps, 1),
            "pickup_pos": whole(-1, last_cell, 2),
            "dropoff_pos": whole(-1, last_cell, 2),
        }
    )


class WarehouseGymnasiumEnv(gymnasium.Env[Any, Any]):
    """One warehouse. Actions are 0 to 6: N, E, S, W, WAIT, PICK, DROP.

    ``info`` has ``action_mask``, ``[7]`` int8 with 1 for each action that does something now, and
    after a step ``motion``, the ``Outcome`` of its motion.

    Args:
        layout: a ``Layout``, its rows or its text; ``None`` is the chapter's.
        backend: name, class or instance of the motion that carries out the moves; of an instance
            the environment takes a copy for itself.
        observation: the form of the observations, see ``make_form``.
        start_pos: where the robot starts without ``randomize``; ``None`` is the usual start.
        max_steps: steps until the episode is truncated, 1 to ``MOST_STEPS``.
        battery: battery units of a full charge, 1 to ``MOST_STEPS``; every step costs one.
        view_radius: cells seen in each direction, 0 to ``MOST_VIEW_RADIUS``.
        randomize: draw pickup, dropoff and start of each episode.
        render_mode: ``"rgb_array"``, ``"ansi"``, ``"human"`` (a window) or ``None``.
        tile_pixels: side of a cell in a picture, at least 2; ``None`` fits it to the layout.

    Raises:
        ValueError: a value that is not allowed; ``LayoutError`` and ``BackendError`` are such.
        TypeError: an argument of another type.
    """

    metadata: dict[str, Any] = {  # noqa: RUF012 - so declared by Gymnasium
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
        randomize: bool = True,
        render_mode: str | None = None,
        tile_pixels: int | None = None,
    ) -> None:
        check_render_mode(render_mode, self.metadata["render_modes"])
        self._layout = as_layout(layout)
        self._start = None if start_pos is None else as_cell("start_pos", start_pos)
        start = self._start or self._layout.usual_start()
        # Environments that shared one motion would move each other's robots.
        own = backend if isinstance(backend, (str, type)) else deepcopy(backend)
        self._warehouse = WarehouseEnv(
            self._layout, start, max_steps, battery, view_radius, backend=own
        )
        self._encoder, self._masks = Encoder(self._warehouse), ActionMasks(self._warehouse)
        self._randomize = as_flag("randomize", randomize)
        if randomize:
            check_room(self._layout)
        form = make_form(observation, _extent(self._warehouse))
        self.observation_space, self._form = form.space, form.of
        self.action_space = spaces.Discrete(len(ACTIONS))
        self.render_mode = render_mode
        if tile_pixels is None:
            tile_pixels = tile_pixels_for(self._layout.height, self._layout.width)
        self._painter = TilePainter(tile_pixels)
        self._window: PictureWindow | None = None
        self._over = UNSTARTED

    @property
    def warehouse(self) -> WarehouseEnv:
        """The chapter's environment within."""
        return self._warehouse

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Start an episode.

        Args:
            seed: of ``np_random``, from which pickup, dropoff, start and whatever chance the
                motion knows are drawn; ``None`` goes on with it.
            options: ``randomize`` (bool), ``layout`` (of the same size) and ``start_pos`` for
                this episode alone, in place of what the environment was made with.

        Raises:
            ValueError: an unknown option or a bad value; nothing has changed.
            TypeError: a value of another type; nothing has changed.
            gymnasium.error.Error: a seed that is not a whole number from 0 on.
        """
        layout, start, randomize = self._options(
            _check_options(options, {"layout", "randomize", "start_pos"})
        )
        super().reset(seed=seed)
        uniforms = self.np_random.random(DRAWS)
        if randomize:
            layout, drawn = draw_stations(layout, uniforms)
            start = start or drawn
        assert start is not None, "what is not drawn has been told"
        self._warehouse.reset_to(layout, start, motion_seed(uniforms))
        self._encoder.forget()
        self._masks.forget()
        self._over = ""
        if self.render_mode == "human":
            self._show()
        return self._form(self._encoder.encode()), {"action_mask": self.action_masks()}

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Carry out one action, an integer 0 to 6.

        Raises:
            ValueError: an action out of range; nothing has changed.
            TypeError: an action that is not an integer.
            ResetNeeded: before a reset or after the end of an episode.
        """
        index = valid_action(action)
        if self._over:
            raise ResetNeeded(f"step(): {self._over}")
        warehouse = self._warehouse
        reward, terminated, truncated = warehouse.advance(index)
        if terminated or truncated:
            self._over = "the episode has ended; a reset() must come first"
        motion = warehouse.last_motion
        assert motion is not None, "every step has a motion"
        info = {"motion": motion.copy(), "action_mask": self.action_masks()}
        if self.render_mode == "human":
            self._show()
        return self._form(self._encoder.encode()), reward, terminated, truncated, info

    def action_masks(self) -> NDArray[np.int8]:
        """Return ``[7]`` int8: 1 for each action that does something now.

        Raises:
            ResetNeeded: before a reset.
        """
        if self._over == UNSTARTED:
            raise ResetNeeded(f"action_masks(): {self._over}")
        return self._masks.mask()

    def render(self) -> Any:
        """Return a picture ``[H, W, 3]`` uint8 or the text; a window is shown by itself."""
        if self.render_mode == "rgb_array":
            return self._picture()
        if self.render_mode == "ansi":
            return self._warehouse.render()
        if self.render_mode is None:
            gymnasium.logger.warn("render() needs a render_mode, given to gymnasium.make")
        return None

    def close(self) -> None:
        """Close the window and let the motion backend go."""
        if self._window is not None:
            self._window.close()
            self._window = None
        self._warehouse.close()
        self._over = "the environment has been closed"

    def _options(self, options: dict[str, Any]) -> tuple[Layout, Cell | None, bool]:
        """Return the layout, the start unless it is to be drawn, and whether to draw."""
        other = options.get("layout")
        layout = self._layout if other is None else as_layout(other)
        if (layout.height, layout.width) != (self._layout.height, self._layout.width):
            raise LayoutError(
                f"the layout has {layout.height} x {layout.width} cells; this environment was "
                f"made for {self._layout.height} x {self._layout.width}"
            )
        randomize = options.get("randomize")
        randomize = self._randomize if randomize is None else as_flag("randomize", randomize)
        if randomize:
            check_room(layout)
        given = options.get("start_pos")
        if given is None and randomize and len(layout.open_cells) > NEEDED:
            return layout, None, True
        start = self._start if given is None else as_cell("start_pos", given)
        start = start or layout.usual_start()
        check_start(layout, start)
        return layout, start, randomize

    def _picture(self) -> NDArray[np.uint8]:
        state = self._warehouse.state
        return self._painter.picture(self._warehouse.layout, state.robot_pos, state.has_item)

    def _show(self) -> None:
        self._window = self._window or PictureWindow("Warehouse")
        self._window.show(self._picture(), self.metadata["render_fps"])


class WarehouseVectorEnv(gymnasium.vector.VectorEnv[Any, Any, Any]):
    """A batch of warehouses, stepped together by NumPy; see ``BatchEnv``.

    Rows are what ``WarehouseGymnasiumEnv`` gives for the seeds ``seed, seed + 1, ...``, but for
    ``info["motion"]``, which has ``blocked``, ``seconds`` and ``joules`` of all rows, and no paths
    or contacts. On the physics backend a batch cannot be pickled or copied.

    Args:
        num_envs: ``B``, at least 1.
        layout: one for all rows, or a list of ``B`` of ``Layout`` for each its own.
        autoreset_mode: an ``AutoresetMode`` or its value, ``"NextStep"``, ``"SameStep"`` or
            ``"Disabled"``.
        backend: as for ``WarehouseGymnasiumEnv``, and so are all further arguments.

    Raises:
        ValueError: a value that is not allowed; ``LayoutError`` and ``BackendError`` are such.
        TypeError: an argument of another type.
    """

    def __init__(
        self,
        num_envs: int = 1,
        layout: GivenLayout | Sequence[Layout] | None = None,
        backend: Backend = "grid",
        observation: str = "dict",
        start_pos: Cell | Sequence[Cell] | None = None,
        max_steps: int = 200,
        battery: int = 200,
        view_radius: int = 2,
        randomize: bool = True,
        autoreset_mode: Any = NEXT_STEP,
        render_mode: str | None = None,
        tile_pixels: int | None = None,
    ) -> None:
        modes = ["rgb_array"]
        check_render_mode(render_mode, modes)
        mode = getattr(autoreset_mode, "value", autoreset_mode)
        layouts = layout if _is_many(layout) else as_layout(cast("GivenLayout | None", layout))
        self._batch = batch = BatchEnv(
            num_envs,
            layouts,
            start_pos,
            max_steps,
            battery,
            view_radius,
            randomize=randomize,
            autoreset_mode=mode,
            backend=backend,
        )
        self.metadata = {
            "render_modes": modes,
            "render_fps": RENDER_FPS,
            "autoreset_mode": AutoresetMode(mode),
        }
        self.num_envs = num_envs = batch.num_envs
        self.render_mode = render_mode
        height, width = batch.size
        extent = Extent(height, width, batch.view_radius, batch.max_battery, batch.max_steps)
        form = make_form(observation, extent)
        self._form = form.of
        self.single_observation_space = form.space
        self.observation_space = batch_space(form.space, num_envs)
        self.single_action_space = spaces.Discrete(len(ACTIONS))
        self.action_space = batch_space(self.single_action_space, num_envs)
        if tile_pixels is None:
            tile_pixels = tile_pixels_for(height, width)
        self._painter = TilePainter(tile_pixels)

    def reset(
        self, *, seed: Seeds = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Start an episode in every row, or in those of ``options["reset_mask"]``.

        Raises:
            ValueError: an unknown option or a bad value; nothing has changed.
            TypeError: a value of another type.
            ResetNeeded: a mask before the first reset.
        """
        mask = _check_options(options, {"reset_mask"}).get("reset_mask")
        try:
            arrays, info = self._batch.reset(seed, mask)
        except EndedError as error:
            raise ResetNeeded(str(error)) from error
        return self._form(arrays), info

    def step(self, actions: ArrayLike) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """Carry out one action in each row; see ``BatchEnv.step``.

        Raises:
            ValueError: a wrong shape, or an action out of range; nothing has changed.
            TypeError: actions that are not integers.
            ResetNeeded: before a reset, or where rows have ended with autoreset disabled.
        """
        try:
            arrays, rewards, terminated, truncated, info = self._batch.step(actions)
        except EndedError as error:
            raise ResetNeeded(str(error)) from error
        if "final_obs" in info:
            info["final_obs"] = self._final(info["final_obs"], info["_final_obs"])
        return self._form(arrays), rewards, terminated, truncated, info

    def action_masks(self) -> NDArray[np.int8]:
        """Return ``[B, 7]`` int8: 1 for each action that does something now.

        Raises:
            ResetNeeded: before a reset.
        """
        try:
            return self._batch.action_masks()
        except EndedError as error:
            raise ResetNeeded(str(error)) from error

    def render(self) -> Any:
        """Return a picture of each row, ``[H, W, 3]`` uint8.

        Raises:
            ResetNeeded: before a reset.
        """
        if self.render_mode == "rgb_array":
            try:
                rows = [self._batch.row(row) for row in range(self.num_envs)]
            except EndedError as error:
                raise ResetNeeded(str(error)) from error
            return tuple(
                self._painter.picture(layout, state.robot_pos, state.has_item)
                for layout, state in rows
            )
        gymnasium.logger.warn("render() needs a render_mode, given to gymnasium.make_vec")
        return None

    def close_extras(self, **kwargs: Any) -> None:
        """Let the motion backend go."""
        # Some versions of Gymnasium close what could not even be made.
        if hasattr(self, "_batch"):
            self._batch.close()

    def _final(self, arrays: dict[str, NDArray[Any]], ended: NDArray[np.bool_]) -> NDArray[Any]:
        """Return ``[B]`` last observations of rows that have ended, as Gymnasium gives them."""
        final, rows = np.full(self.num_envs, None, object), np.flatnonzero(ended)
        # Most rows go on, and it would take far longer than the step to make these of all of them.
        some: Any = {key: values[rows] for key, values in arrays.items()}
        observations = iterate(self.observation_space, self._form(some))
        for row, observation in zip(rows, observations, strict=True):
            final[row] = observation
        return final


def _extent(env: WarehouseEnv) -> Extent:
    return Extent(env.height, env.width, env.view_radius, env.max_battery, env.max_steps)


def _check_options(options: object, allowed: set[str]) -> dict[str, Any]:
    """Return options that are known by name.

    Raises:
        TypeError: they are no dict.
        ValueError: one is unknown.
    """
    if options is None:
        return {}
    if not isinstance(options, dict):
        raise TypeError(f"options is {options!r}; it must be a dict")
    unknown = sorted(map(repr, options.keys() - allowed))
    if unknown:
        raise ValueError(
            f"unknown options: {', '.join(unknown)}; allowed: {', '.join(sorted(allowed))}"
        )
    return options


def check_render_mode(mode: str | None, allowed: list[str]) -> None:
    """Refuse an unknown render mode.

    Raises:
        ValueError: listing those allowed.
    """
    if mode is not None and mode not in allowed:
        raise ValueError(f"render_mode is {mode!r}; allowed: None, {', '.join(allowed)}")


def _is_many(layout: GivenLayout | Sequence[Layout] | None) -> TypeGuard[Sequence[Layout]]:
    return (
        not isinstance(layout, (str, Layout))
        and isinstance(layout, Sequence)
        and any(isinstance(each, Layout) for each in layout)
    )


gymnasium.register(
    ID,
    entry_point=f"{__name__}:{WarehouseGymnasiumEnv.__name__}",
    vector_entry_point=f"{__name__}:{WarehouseVectorEnv.__name__}",
)
