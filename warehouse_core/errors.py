"""The errors that a caller may expect; any other exception is a fault of this project.

::

    WarehouseError
    |-- LayoutError     (ValueError)    a layout, a cell in it, or a map file
    |-- BackendError    (ValueError)    a motion backend by name
    |-- RecordError     (ValueError)    a file that should be a record
    |-- FormatError     (ValueError)    a file format for a picture or an animation
    |-- EndedError      (RuntimeError)  a step when there is no episode
    +-- NoDisplayError  (RuntimeError)  a window where none can be opened

Errors of agents and experiments are children too (``agents/errors.py``). Arguments of a wrong type
or out of range raise plain ``TypeError`` and ``ValueError``.
"""


class WarehouseError(Exception):
    """An error whose message names the bad value, where it stands and what is allowed."""


class LayoutError(WarehouseError, ValueError):
    """A layout that cannot be used; the message says where and what is allowed."""


class BackendError(WarehouseError, ValueError):
    """No backend has that name, or its requirements are missing or broken."""


class RecordError(WarehouseError, ValueError):
    """A file that is not a readable record; the message names it and says why."""


class FormatError(WarehouseError, ValueError):
    """An unknown file format, or one whose requirements are not installed."""


class EndedError(WarehouseError, RuntimeError):
    """A step before a reset, or of rows that have ended and do not restart by themselves."""


class NoDisplayError(WarehouseError, RuntimeError):
    """A window was requested where none can be opened."""
