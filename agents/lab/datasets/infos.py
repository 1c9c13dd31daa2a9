"""The same infos for every step, for those who record with Minari's own ``DataCollector``."""

from __future__ import annotations

from typing import Any

import numpy as np
from minari import StepDataCallback

from agents.lab.datasets.source import MOTION


class EvenInfos(StepDataCallback):
    """Infos as in the datasets of ``warehouse export``: masks, and what the motion did.

    ``Warehouse-v0`` has ``info["motion"]`` after a step and not after a reset, and it has paths of
    different lengths; ``DataCollector(env, record_infos=True)`` needs the same arrays each time.
    """

    def __call__(self, *step: Any, **named: Any) -> Any:
        """Return the data of a step or of a reset."""
        data = super().__call__(*step, **named)
        motion = data["info"].get("motion")
        values = [getattr(motion, name, 0.0) for name in MOTION]
        data["info"] = {
            "action_mask": data["info"]["action_mask"],
            "motion": np.array(values, np.float64),
        }
        return data
