"""The errors of agents and experiments that a user may expect, and what caused one."""

from __future__ import annotations

import traceback
from pathlib import Path

from warehouse_core.errors import WarehouseError


class AgentError(WarehouseError, ValueError):
    """No agent of that name, or a file, class or model that is none."""


class ParameterError(WarehouseError, ValueError):
    """An unknown parameter of an experiment, or a value that it cannot take."""


class EpisodeError(WarehouseError):
    """An episode that could not be run; the message says which and why."""


class StoreError(WarehouseError):
    """A file of results that cannot be used or written; the message says which and why."""


class ClusterError(WarehouseError):
    """A cluster that cannot be reached or used; the message says why."""


class WorkerError(WarehouseError):
    """A process of this machine that ended before its work was done."""


def reason_of(error: BaseException, file: Path | None = None) -> str:
    """Return what an exception says and where it was raised.

    Args:
        error: that was caught.
        file: the place is where this one was last at work, if it was.
    """
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if file is not None and _is_same(frame.filename, file)]
    place = (own or frames)[-1:]
    where = "".join(f" ({Path(frame.filename).name}, line {frame.lineno})" for frame in place)
    try:
        text = f": {error}" if str(error) else ""
    except Exception:  # an exception may be as broken as what raised it
        text = ""
    return f"{type(error).__name__}{text}{where}"


def _is_same(name: str, file: Path) -> bool:
    return Path(name).resolve() == file.resolve()
