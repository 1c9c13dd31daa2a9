"""A fleet as environments of PettingZoo; needs the extra ``fleet``.

The rules are not here: this package adds spaces and dictionaries to ``FleetEnv``.
"""

from __future__ import annotations

from typing import Any

from warehouse_core.errors import BackendError
from warehouse_core.extras import install_command

try:
    from pettingzoo.utils.conversions import parallel_to_aec
except ModuleNotFoundError as error:
    raise BackendError(
        f"environments of PettingZoo need {error.name}, which is not installed: "
        f"{install_command('fleet')}"
    ) from error

from warehouse_core.pettingzoo_env.parallel import WarehouseParallelEnv

parallel_env = WarehouseParallelEnv


def env(**arguments: Any) -> Any:
    """Return ``parallel_env`` as an ``AECEnv``, in which robots act in turn; see there.

    PettingZoo's ``api_test`` warns of ``observation="dict"``, as of every ``Dict`` outside of its
    own games; ``observation="vector"`` passes it without a warning.

    Example:
        >>> from warehouse_core.pettingzoo_env import env
        >>> turns = env(robots=2, orders=0.1)
        >>> turns.reset(seed=1)
        >>> turns.agent_selection
        'robot_0'
    """
    return parallel_to_aec(parallel_env(**arguments))


__all__ = ["env", "parallel_env"]
