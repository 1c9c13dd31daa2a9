"""The errors that callers can expect. Any other exception is a bug.

::

    WarehouseError
    |-- LayoutError     (ValueError)    an invalid layout, cell or map file
    |-- OrderError      (ValueError)    an invalid order or file of orders
    |-- BackendError    (ValueError)    an unknown or unusable motion backend
    |-- RecordError     (ValueError)    an unreadable record
    |-- FormatError     (ValueError)    an unusable file format of a picture or animation
    |-- EndedError      (RuntimeError)  a step outside an episode
    +-- NoDisplayError  (RuntimeError)  a window without a display

The errors of agents and experiments in ``agents/errors.py`` are also children of
``WarehouseError``. Arguments of the wrong type raise a plain ``TypeError``, and arguments out of
range a plain ``ValueError``.
"""

__all__ = [
    "BackendError",
    "EndedError",
    "FormatError",
    "LayoutError",
    "NoDisplayError",
    "OrderError",
    "RecordError",
    "WarehouseError",
]


class WarehouseError(Exception):
    """An error whose message names the bad value, its place and what is allowed.

    Example:
        >>> from warehouse_core import WarehouseEnv, WarehouseError
        >>> try:
        ...     WarehouseEnv(["P.", "..D"])
        ... except WarehouseError as error:
        ...     print(error)
        row 1 has 3 columns where row 0 has 2; all rows must be equally long
    """


class LayoutError(WarehouseError, ValueError):
    """An invalid layout, a cell that cannot be used in it, or an invalid map file.

    Example:
        >>> from warehouse_core import Layout
        >>> Layout(["P..", "..X"])
        Traceback (most recent call last):
            ...
        warehouse_core.errors.LayoutError: row 1, column 2: 'X' is not a tile; allowed: # ...
    """


class OrderError(WarehouseError, ValueError):
    """An order that cannot be carried out in its layout, or an invalid file of orders.

    Example:
        >>> from warehouse_core import FleetEnv, Order
        >>> FleetEnv(["P.#D"], 1, orders=[Order(0, 9, (0, 0), (0, 2))]).reset()
        Traceback (most recent call last):
            ...
        warehouse_core.errors.OrderError: order 0: dropoff row 0, column 2 is wall; it must be ...
    """


class BackendError(WarehouseError, ValueError):
    """A backend is unknown or unsuitable, or its requirements are missing or broken.

    Example:
        >>> from warehouse_core import WarehouseEnv
        >>> WarehouseEnv(backend="train")
        Traceback (most recent call last):
            ...
        warehouse_core.errors.BackendError: no backend is called 'train'; installed: driving, ...
    """


class RecordError(WarehouseError, ValueError):
    """A file is not a readable record, or a record is too large to write.

    Example:
        >>> from pathlib import Path
        >>> from warehouse_core import Episode
        >>> size = Path("notes.npz").write_text("no record")
        >>> Episode.load("notes.npz")
        Traceback (most recent call last):
            ...
        warehouse_core.errors.RecordError: notes.npz: not an .npz file
    """


class FormatError(WarehouseError, ValueError):
    """A file format is unknown, or its requirements are not installed.

    Example:
        >>> from warehouse_core import WarehouseEnv, replay_animation
        >>> replay_animation([WarehouseEnv().render_grid()], window=False).save("replay.doc")
        Traceback (most recent call last):
            ...
        warehouse_core.errors.FormatError: replay.doc: cannot save as .doc; allowed: .gif, ...
    """


class EndedError(WarehouseError, RuntimeError):
    """A step before the first reset, or outside of the episode that is being run or recorded.

    Example:
        >>> from warehouse_core import BatchEnv
        >>> BatchEnv(1).step([0])
        Traceback (most recent call last):
            ...
        warehouse_core.errors.EndedError: step() needs a reset() before it
    """


class NoDisplayError(WarehouseError, RuntimeError):
    """A window cannot be opened because there is no display.

    Example:
        >>> from warehouse_core.gymnasium_env import WarehouseGymnasiumEnv
        >>> WarehouseGymnasiumEnv(render_mode="human").reset(seed=1)  # without a display
        Traceback (most recent call last):
            ...
        warehouse_core.errors.NoDisplayError: render_mode="human" needs a window, but none can ...
    """
