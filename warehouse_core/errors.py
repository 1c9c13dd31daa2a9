"""The errors that a caller may expect; any other exception is a bug.

::

    WarehouseError
    |-- LayoutError     (ValueError)    a layout, a cell in it, or a map file
    |-- OrderError      (ValueError)    an order of a fleet, or a file of orders
    |-- BackendError    (ValueError)    a motion backend by name
    |-- RecordError     (ValueError)    a file that is not a readable record
    |-- FormatError     (ValueError)    a file format for a picture or an animation
    |-- EndedError      (RuntimeError)  a step when there is no episode
    +-- NoDisplayError  (RuntimeError)  a window without a display

Errors of agents and experiments are children too (``agents/errors.py``). Arguments of a wrong type
or out of range raise plain ``TypeError`` and ``ValueError``.
"""


class WarehouseError(Exception):
    """An error whose message names the bad value, its place and what is allowed."""


class LayoutError(WarehouseError, ValueError):
    """An invalid layout, a cell that cannot be used in it, or an invalid map file."""


class OrderError(WarehouseError, ValueError):
    """An order that cannot be carried out in its layout, or an invalid file of orders."""


class BackendError(WarehouseError, ValueError):
    """A backend is unknown or unsuitable, or its requirements are missing or broken."""


class RecordError(WarehouseError, ValueError):
    """A file is not a readable record, or a record is too large to write."""


class FormatError(WarehouseError, ValueError):
    """A file format is unknown, or its requirements are not installed."""


class EndedError(WarehouseError, RuntimeError):
    """A step before the first reset, or after the end of an episode without autoreset."""


class NoDisplayError(WarehouseError, RuntimeError):
    """A window cannot be opened because there is no display."""
