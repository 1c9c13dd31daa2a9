"""Many warehouses as a ``gymnasium.vector.VectorEnv``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, cast

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.error import ResetNeeded
from gymnasium.vector.utils import batch_space, iterate
from numpy.typing import ArrayLike, NDArray

from warehouse_core.arguments import MAX_STEPS, one_of, whole_number
from warehouse_core.batch import BatchEnv
from warehouse_core.batch.array_env import NEXT_STEP, Seeds
from warehouse_core.errors import EndedError
from warehouse_core.gymnasium_env.spaces import (
    FORMS,
    MARKED,
    RENDER_FPS,
    Extent,
    Limited,
    check_options,
    check_render_mode,
    make_form,
)
from warehouse_core.listing import Unlisted
from warehouse_core.motion.backends import Backend
from warehouse_core.render.painter import TilePainter, tile_pixels_for
from warehouse_core.wording import brief
from warehouse_core.world.actions import ACTIONS
from warehouse_core.world.layout import Layout
from warehouse_core.world.named_layouts import GivenLayout, as_layout
from warehouse_core.world.tiles import TILES, Cell

AutoresetMode: Any = getattr(gymnasium.vector, "AutoresetMode", str)
"""Gymnasium's enumeration. Version 1.0 has none, so strings are used."""


class WarehouseVectorEnv(Unlisted, Limited, gymnasium.vector.VectorEnv[Any, Any, Any]):
    """A batch of ``Warehouse-v0``: ``BatchEnv`` with the vector interface of Gymnasium.

    Description:
        Row ``b`` equals a ``WarehouseGymnasiumEnv`` with the seed ``seed + b``.

    Actions:
        ``MultiDiscrete``, ``[B]``, the actions of ``WarehouseGymnasiumEnv``.

    Observations:
        A batch of the observations of ``WarehouseGymnasiumEnv``. ``info["motion"]`` has
        ``blocked``, ``seconds`` and ``joules`` of all rows, but neither paths nor contacts.

    Rewards:
        The table in ``task/rules.py``, ``[B]`` float64.

    Ends:
        Rows end like ``WarehouseGymnasiumEnv``, and restart as ``autoreset_mode`` determines.

    Args:
        num_envs: number of rows ``B``, at least 1.
        layout: one layout for all rows, in a form that ``WarehouseGymnasiumEnv`` accepts, or a list
            of ``B``. A list of strings is one layout if any string is a row of tiles.
        autoreset_mode: an ``AutoresetMode`` or its value: ``"NextStep"``, ``"SameStep"`` or
            ``"Disabled"``.
        max_episode_steps: limit of an episode that is lower than ``max_steps``, for which
            ``gymnasium.make`` uses a wrapper; ``None`` or -1 for no such limit. Spaces still depend
            on ``max_steps``.
        backend: name, class or instance of a motion, as in ``WarehouseGymnasiumEnv``. All other
            arguments are the same too. With the physics backend a batch can be neither pickled nor
            copied.
        scan: must be 0, because a batch has no sensors.

    Raises:
        ValueError: an argument is not allowed; it may be a ``LayoutError`` or ``BackendError``.
        TypeError: an argument has the wrong type.

    Example:
        >>> from warehouse_core.gymnasium_env import WarehouseVectorEnv
        >>> envs = WarehouseVectorEnv(4)
        >>> observations, infos = envs.reset(seed=1)
        >>> observations, rewards, terminated, truncated, infos = envs.step([0, 1, 2, 3])
        >>> rewards.shape
        (4,)
    """

    def __init__(
        self,
        num_envs: int = 1,
        layout: GivenLayout | Sequence[GivenLayout] | None = None,
        backend: Backend = "grid",
        observation: str = "dict",
        start_pos: Cell | Sequence[Cell] | None = None,
        max_steps: int = 200,
        battery: int = 200,
        view_radius: int = 2,
        randomize: bool | str = True,
        autoreset_mode: Any = NEXT_STEP,
        max_episode_steps: int | None = None,
        render_mode: str | None = None,
        tile_pixels: int | None = None,
        scan: int = 0,
    ) -> None:
        if whole_number("scan", scan, 0):
            raise ValueError(
                f"scan is {brief(scan)}; a batch has no sensors, so it must be 0; for a scan use "
                'gymnasium.make_vec(..., vectorization_mode="sync")'
            )
        modes = ["rgb_array"]
        check_render_mode(render_mode, modes)
        mode = getattr(autoreset_mode, "value", autoreset_mode)
        limit = max_steps = whole_number("max_steps", max_steps, 1, MAX_STEPS)
        if max_episode_steps is not None:
            other = whole_number("max_episode_steps", max_episode_steps)
            limit = (
                limit if other == -1 else min(limit, whole_number("max_episode_steps", other, 1))
            )
        one_of("observation", observation, FORMS)
        self._batch = batch = BatchEnv(
            num_envs,
            _layouts(layout),
            start_pos,
            limit,
            battery,
            view_radius,
            randomize=randomize,
            autoreset_mode=mode,
            backend=backend,
            marked=MARKED.get(observation, ()),
        )
        self.autoreset_mode = AutoresetMode(mode)
        self.metadata = {
            "render_modes": modes,
            "render_fps": RENDER_FPS,
            "autoreset_mode": self.autoreset_mode,
        }
        self.num_envs, self.max_steps = batch.num_envs, batch.max_steps
        self.render_mode = render_mode
        height, width = batch.size
        extent = Extent(height, width, batch.view_radius, batch.max_battery, max_steps)
        form = make_form(observation, extent)
        self._form = form.of
        self.single_observation_space = form.space
        self.observation_space = batch_space(form.space, self.num_envs)
        self.single_action_space = spaces.Discrete(len(ACTIONS))
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        if tile_pixels is None:
            tile_pixels = tile_pixels_for(height, width)
        self._painter = TilePainter(tile_pixels)

    @property
    def np_random_seed(self) -> Any:
        """The seed of each row, ``B`` integers, like in Gymnasium's ``SyncVectorEnv``."""
        return self._batch.seeds

    @property  # type: ignore[misc] # it has no setter, like in SyncVectorEnv
    def np_random(self) -> Any:
        """The random stream of each row, ``B`` generators."""
        return self._batch.streams

    def reset(
        self, *, seed: Seeds = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Start an episode in every row, or in the rows of ``options["reset_mask"]``.

        Raises:
            ValueError: an option is unknown or its value is not allowed; nothing has changed.
            TypeError: a value has the wrong type.
            ResetNeeded: the first reset has a mask.
        """
        mask = check_options(options, {"reset_mask"}).get("reset_mask")
        try:
            arrays, info = self._batch.reset(seed, mask)
        except EndedError as error:
            raise ResetNeeded(str(error)) from error
        return self._form(arrays), info

    def step(self, actions: ArrayLike) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """Carry out one action in each row; see ``BatchEnv.step``.

        Raises:
            ValueError: the shape is wrong, or an action is out of range; nothing has changed.
            TypeError: the actions are not integers.
            ResetNeeded: there has been no reset, or rows have ended in the disabled mode.
        """
        try:
            arrays, rewards, terminated, truncated, info = self._batch.step(actions)
        except EndedError as error:
            raise ResetNeeded(str(error)) from error
        if "final_obs" in info:
            info["final_obs"] = self._final(info["final_obs"], info["_final_obs"])
        return self._form(arrays), rewards, terminated, truncated, info

    def action_masks(self) -> NDArray[np.int8]:
        """Return the masks ``[B, 7]`` int8: 1 for each action with an effect.

        Raises:
            ResetNeeded: there has been no reset.
        """
        try:
            return self._batch.action_masks()
        except EndedError as error:
            raise ResetNeeded(str(error)) from error

    def render(self) -> Any:
        """Return a picture ``[H, W, 3]`` uint8 of each row.

        Raises:
            ResetNeeded: there has been no reset.
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
        """Close the motion backend."""
        # Some versions of Gymnasium close an environment whose construction failed.
        if hasattr(self, "_batch"):
            self._batch.close()

    def _final(self, arrays: dict[str, NDArray[Any]], ended: NDArray[np.bool_]) -> NDArray[Any]:
        """Return the final observations ``[B]``, ``None`` for rows that have not ended."""
        final, rows = np.full(self.num_envs, None, object), np.flatnonzero(ended)
        # Only rows that have ended are converted, as converting all takes longer than the step.
        some: Any = {key: values[rows] for key, values in arrays.items()}
        observations = iterate(self.observation_space, self._form(some))
        for row, observation in zip(rows, observations, strict=True):
            final[row] = observation
        return final


def _layouts(given: GivenLayout | Sequence[GivenLayout] | None) -> Layout | list[Layout]:
    """Return one layout or several; strings are one layout if any of them is a row of tiles."""
    if isinstance(given, Sequence) and not isinstance(given, (str, bytes, range)) and given:
        strings = [each for each in given if isinstance(each, str)]
        if len(strings) < len(given) or not any(set(text) <= TILES.keys() for text in strings):
            return [as_layout(each) for each in given]
    return as_layout(cast("GivenLayout | None", given))
