"""Observation spaces, and checks of options that several environments share."""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from typing import Any, NamedTuple

import numpy as np
from gymnasium import spaces
from gymnasium.envs.registration import EnvSpec
from numpy.typing import ArrayLike

from warehouse_core.arguments import MAX_STEPS, instance_of, one_of, whole_number
from warehouse_core.render.observation_image import ObservationImage
from warehouse_core.render.window import may_have_display
from warehouse_core.task.encoding import MARKED_TILES, ObservationArrays, vector, vector_limits
from warehouse_core.wording import brief
from warehouse_core.world.layout import Layout
from warehouse_core.world.tiles import CELL_CODES

FORMS = ("dict", "vector", "image")
"""Names of the forms of observations; see ``make_form``."""

MARKED = {"vector": MARKED_TILES}
"""Tiles for forms that are made from ``marks`` instead of codes, which is faster."""

RENDER_FPS = 8

MAX_VIEW_RADIUS = 500
"""Limit on the view radius. The window then has a million cells."""

MIN_SIDE = 2
"""Fewest rows and columns of a space; Gymnasium warns of equal lower and upper bounds."""


class Form(NamedTuple):
    """A form of observations: their space, and the function that makes them from arrays.

    Attributes:
        space: space of the observations.
        of: function that returns an observation in this form, given its arrays.

    Example:
        >>> from warehouse_core import WarehouseEnv
        >>> from warehouse_core.gymnasium_env import Extent, make_form
        >>> from warehouse_core.task import encode
        >>> form = make_form("vector", Extent(7, 12, 2, 200, 200))
        >>> form.space.contains(form.of(encode(WarehouseEnv().reset())))
        True
    """

    space: spaces.Space[Any]
    of: Callable[[ObservationArrays], Any]


class Extent(NamedTuple):
    """The limits of the values in an observation.

    Example:
        >>> from warehouse_core.gymnasium_env import Extent
        >>> Extent(height=7, width=12, view_radius=2, battery=200, max_steps=200)
        Extent(height=7, width=12, view_radius=2, battery=200, max_steps=200)
    """

    height: int
    width: int
    view_radius: int
    battery: int
    max_steps: int


def make_form(name: str, extent: Extent) -> Form:
    """Return a form of observations by name.

    ============  =================================================================================
    ``"dict"``    a flat ``Dict`` with the keys of the chapter's observation, see
                  ``ObservationArrays`` in ``task/encoding.py``. The cell of a pickup or dropoff
                  that does not exist is ``(-1, -1)``.
    ``"vector"``  a ``Box`` of one dimension, see ``encoding.vector``
    ``"image"``   a ``Box`` of uint8 ``[8 (H + 1), 8 W, 3]``, see ``render/observation_image.py``
    ============  =================================================================================

    Raises:
        ValueError: the name is unknown, battery or steps exceed ``MAX_STEPS``, or the view radius
            exceeds ``MAX_VIEW_RADIUS``.

    Example:
        >>> from warehouse_core.gymnasium_env import Extent, make_form
        >>> make_form("image", Extent(7, 12, 2, 200, 200)).space.shape
        (64, 96, 3)
    """
    one_of("observation", name, FORMS)
    height, width, view_radius, battery, max_steps = instance_of("extent", extent, Extent)
    whole_number("battery", battery, 1, MAX_STEPS)
    whole_number("max_steps", max_steps, 1, MAX_STEPS)
    whole_number("view_radius", view_radius, 0, MAX_VIEW_RADIUS)
    if name == "dict":
        return Form(_dict_space(extent), _unchanged)
    if name == "vector":
        rows, columns = max(height, MIN_SIDE), max(width, MIN_SIDE)
        low, high = vector_limits(rows, columns, view_radius, battery, max_steps)
        return Form(spaces.Box(low, high, dtype=np.float32), vector)
    image = ObservationImage(height, width, battery, max_steps)
    return Form(spaces.Box(0, 255, image.shape, np.uint8), image.paint)


def _unchanged(arrays: ObservationArrays) -> ObservationArrays:
    return arrays  # a lambda could not be pickled


def _dict_space(extent: Extent) -> spaces.Dict:
    last_cell = np.maximum([extent.height, extent.width], MIN_SIDE) - 1
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


def listed(metadata: dict[str, Any]) -> dict[str, Any]:
    """Return the metadata without the mode ``"human"`` if there is no display.

    Checkers of environments try all listed modes.
    """
    if may_have_display():
        return metadata
    modes = [mode for mode in metadata["render_modes"] if mode != "human"]
    return metadata | {"render_modes": modes}


class Limited:
    """A base class of environments whose spec has the right limit of steps and works as JSON."""

    max_steps: int
    _spec: EnvSpec | None = None

    @property
    def spec(self) -> EnvSpec | None:
        """The spec from which Gymnasium has made the environment.

        Its ``max_episode_steps`` is ``max_steps``, and layouts are given by their rows.
        """
        return self._spec

    @spec.setter
    def spec(self, spec: EnvSpec | None) -> None:
        self._spec = copy(spec)
        if self._spec is not None:
            self._spec.max_episode_steps = self.max_steps
            kwargs = self._spec.kwargs
            if "layout" in kwargs:
                self._spec.kwargs = {**kwargs, "layout": _rows_of(kwargs["layout"])}


def _rows_of(layout: Any) -> Any:
    """Return the rows of a layout or of several; other values are returned unchanged."""
    if isinstance(layout, Layout):
        return list(layout.rows)
    if isinstance(layout, (list, tuple)):
        return [_rows_of(each) for each in layout]
    return layout


def check_options(options: object, allowed: set[str]) -> dict[str, Any]:
    """Return ``options`` as a dict, after checking that all its keys are allowed."""
    if options is None:
        return {}
    if not isinstance(options, dict):
        raise TypeError(f"options is {brief(options)}; it must be a dict")
    unknown = sorted(map(brief, options.keys() - allowed))
    if unknown:
        raise ValueError(
            f"unknown options: {', '.join(unknown)}; allowed: {', '.join(sorted(allowed))}"
        )
    return options


def check_render_mode(mode: str | None, allowed: list[str]) -> None:
    """Raise ``ValueError`` if a render mode is unknown."""
    one_of("render_mode", mode, [None, *allowed])
