"""Many warehouses under continuous control as a ``gymnasium.vector.VectorEnv``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.error import ResetNeeded
from gymnasium.vector.utils import batch_space
from numpy.typing import ArrayLike, NDArray

from warehouse_core import Cell
from warehouse_core.arguments import MAX_ENVS, one_of, whole_number
from warehouse_core.batch.array_env import (
    AUTORESET_MODES,
    DISABLED,
    NEXT_STEP,
    SAME_STEP,
    Seeds,
    checked_mask,
    checked_seeds,
)
from warehouse_core.errors import EndedError
from warehouse_core.gymnasium_env.spaces import check_options
from warehouse_core.gymnasium_env.vector import AutoresetMode
from warehouse_core.world.named_layouts import GivenLayout
from warehouse_physics.disturbances import Disturbances
from warehouse_physics.drive.drives import VELOCITY
from warehouse_physics.drive.env import checked_actions, checked_settings
from warehouse_physics.drive.observations import VECTOR, DriveForm
from warehouse_physics.drive.rows import DriveRows
from warehouse_physics.spec import RobotSpec


class DriveVectorEnv(gymnasium.vector.VectorEnv[Any, Any, Any]):
    """``B`` warehouses of ``WarehouseDrive-v0`` that share pymunk spaces.

    Description:
        Row ``b`` equals a ``DriveEnv`` with the seed ``seed + b``. Positions differ by less than a
        micrometre after a minute, because the warehouses of a space have different corners.

    Actions:
        ``[B, 2]``, the actions of ``DriveEnv``.

    Observations:
        A batch of the observations of ``DriveEnv``. ``info`` has ``cell``, ``joules`` and
        ``impulse`` of all rows.

    Rewards:
        The rewards of ``DriveEnv``, ``[B]`` float64.

    Ends:
        Rows end like ``DriveEnv``, and restart as ``autoreset_mode`` determines.

    Args:
        num_envs: number of rows ``B``, at least 1.
        autoreset_mode: an ``AutoresetMode`` or its value: ``"NextStep"``, ``"SameStep"`` or
            ``"Disabled"``.
        layout: see ``DriveEnv``, as all other arguments. Crates, obstacles and bodies of users are
            possible in ``DriveEnv`` only.

    Raises:
        ValueError: an argument is not allowed; it may be a ``LayoutError``.
        TypeError: an argument has the wrong type.

    Example:
        >>> import gymnasium
        >>> name = "warehouse_physics.drive:WarehouseDrive-v0"
        >>> envs = gymnasium.make_vec(name, num_envs=4)
        >>> observations, infos = envs.reset(seed=1)
        >>> observations, rewards, terminated, truncated, infos = envs.step([[1.0, 0.0]] * 4)
        >>> rewards.shape
        (4,)
    """

    def __init__(
        self,
        num_envs: int = 1,
        layout: GivenLayout | None = None,
        control: str = VELOCITY,
        *,
        spec: RobotSpec | None = None,
        disturbances: Disturbances | None = None,
        rate: float = 10.0,
        rays: int = 16,
        observation: str = VECTOR,
        randomize: bool | str = True,
        start_pos: Cell | None = None,
        max_seconds: float | None = None,
        battery: float | None = None,
        autoreset_mode: Any = NEXT_STEP,
    ) -> None:
        mode = one_of(
            "autoreset_mode", getattr(autoreset_mode, "value", autoreset_mode), AUTORESET_MODES
        )
        self.num_envs = whole_number("num_envs", num_envs, 1, MAX_ENVS)
        self._settings = checked_settings(
            layout, control, spec, disturbances, rate, rays,
            randomize=randomize, start_pos=start_pos, max_seconds=max_seconds, battery=battery,
        )  # fmt: skip
        self._mode = mode
        self.autoreset_mode = AutoresetMode(mode)
        self.metadata = {"render_modes": [], "autoreset_mode": self.autoreset_mode}
        self._form = DriveForm(observation, self._settings)
        self.single_observation_space = self._form.space
        self.observation_space = batch_space(self._form.space, self.num_envs)
        self.single_action_space = spaces.Box(-1.0, 1.0, (2,), np.float32)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self._rows = DriveRows(self._settings, self.num_envs)
        self._streams: list[np.random.Generator | None] = [None] * self.num_envs
        self._ended = np.zeros(self.num_envs, np.bool_)
        self._started = False

    @property
    def rows(self) -> DriveRows:
        """The state of all rows as arrays."""
        return self._rows

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
        seeds = checked_seeds(seed, self.num_envs)
        try:
            chosen = checked_mask(mask, self.num_envs, not self._started)
        except EndedError as error:
            raise ResetNeeded(str(error)) from error
        self._begin(np.flatnonzero(chosen), seeds)
        self._started = True
        return self._form.of(self._rows), self._info(*np.zeros((2, self.num_envs)))

    def step(self, actions: ArrayLike) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """Carry out one action in each row for the period of the controller.

        Raises:
            ValueError: the shape is wrong, or a number is not finite; nothing has changed.
            TypeError: the actions are not numbers.
            ResetNeeded: there has been no reset, or rows have ended in the disabled mode.
        """
        chosen = checked_actions(actions, (self.num_envs, 2))
        if not self._started:
            raise ResetNeeded("step() needs a reset() before it")
        if self._mode == DISABLED and self._ended.any():
            raise ResetNeeded(
                f"{self._ended.sum()} rows have ended, row {self._ended.argmax()} first; they must "
                "be reset with a mask before the next step"
            )
        over = self._ended.copy()
        step = self._rows.step(chosen)
        info = self._info(step.joules, step.impulses)
        if over.any():  # In the next-step mode, these rows only start their next episodes.
            self._begin(np.flatnonzero(over))
            for values in (step.rewards, step.terminated, step.truncated, *info.values()):
                values[over] = 0
            info["cell"] = self._rows.cells()
        self._ended = step.terminated | step.truncated
        if self._mode == SAME_STEP and self._ended.any():
            ended, self._ended = self._ended, np.zeros_like(self._ended)
            info |= self._final(ended, info)
            self._begin(np.flatnonzero(ended))
        return self._form.of(self._rows), step.rewards, step.terminated, step.truncated, info

    def _begin(self, rows: NDArray[np.intp], seeds: Sequence[int | None] | None = None) -> None:
        """Start episodes in some rows; rows without a seed draw it from their random streams."""
        chosen = []
        for row in rows.tolist():
            seed = None if seeds is None else seeds[row]
            if seed is not None or self._streams[row] is None:
                self._streams[row] = gymnasium.utils.seeding.np_random(seed)[0]
            stream = self._streams[row]
            assert stream is not None
            chosen.append(int(stream.integers(2**32)) if seed is None else seed)
        self._rows.begin(rows.tolist(), chosen)
        self._ended[rows] = False

    def _info(self, joules: Any, impulses: Any) -> dict[str, Any]:
        return {"cell": self._rows.cells(), "joules": joules, "impulse": impulses}

    def _final(self, ended: NDArray[np.bool_], info: dict[str, Any]) -> dict[str, Any]:
        """Return the last observations and infos of rows that have ended."""
        observed, final = self._form.of(self._rows), np.full(self.num_envs, None, object)
        for row in np.flatnonzero(ended).tolist():
            final[row] = (
                {key: values[row] for key, values in observed.items()}
                if isinstance(observed, dict)
                else observed[row]
            )
        return {
            "final_obs": final,
            "_final_obs": ended.copy(),
            "final_info": {key: values.copy() for key, values in info.items()},
            "_final_info": ended.copy(),
        }
