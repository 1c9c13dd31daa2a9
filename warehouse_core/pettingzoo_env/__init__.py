"""A fleet as environments of PettingZoo, which need the extra ``fleet``.

This package has no rules. It adds spaces and dictionaries to ``FleetEnv``.
"""

from __future__ import annotations

from typing import Any

from warehouse_core.errors import BackendError
from warehouse_core.extras import not_installed

try:
    from pettingzoo.utils.conversions import parallel_to_aec
except ModuleNotFoundError as error:
    raise BackendError(not_installed("environments of PettingZoo need", error, "fleet")) from error

from warehouse_core.pettingzoo_env.parallel import WarehouseParallelEnv

parallel_env = WarehouseParallelEnv


def env(**arguments: Any) -> Any:
    """Return an ``AECEnv``, in which robots act in turn, with the arguments of ``parallel_env``.

    PettingZoo's ``api_test`` warns about ``observation="dict"``, as it does about every ``Dict``
    except in its own games. With ``observation="vector"`` it prints no warning.

    Example:
        >>> from warehouse_core.pettingzoo_env import env
        >>> turns = env(robots=2, orders=0.1)
        >>> turns.reset(seed=1)
        >>> turns.agent_selection
        'robot_0'
    """
    return parallel_to_aec(parallel_env(**arguments))


__all__ = ["env", "parallel_env"]
