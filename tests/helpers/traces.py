"""The chapter's recorded episodes, and a comparison of an environment with them."""

import gzip
import json
import random
from pathlib import Path
from typing import Any

import pytest

from warehouse_core import WarehouseEnv
from warehouse_core.motion.backends import Backend

RECORDED = gzip.decompress((Path(__file__).parents[1] / "data" / "traces.jsonl.gz").read_bytes())
TRACES = [json.loads(line) for line in RECORDED.splitlines()]
over_traces = pytest.mark.parametrize("trace", TRACES, ids=range(len(TRACES)))


def env_of(trace: dict[str, Any], backend: Backend = "grid") -> WarehouseEnv:
    arguments = dict(trace["constructor"])
    if "start_pos" in arguments:
        arguments["start_pos"] = tuple(arguments["start_pos"])
    return WarehouseEnv(**arguments, backend=backend)


def as_json(observation: object) -> Any:
    return json.loads(json.dumps(observation))


def assert_as_recorded(env: WarehouseEnv, trace: dict[str, Any]) -> None:
    """Replay both episodes of a trace; rewards may differ by 1e-9, everything else is equal."""
    for episode in trace["episodes"]:
        random.seed(episode["seed"])
        observation = env.reset(randomize=episode["randomize"])
        assert as_json(observation) == episode["first_observation"]
        for step in episode["steps"]:
            observation, reward, terminated, truncated, info = env.step(step["action"])
            assert as_json(observation) == step["observation"]
            assert reward == pytest.approx(step["reward"], abs=1e-9)
            assert (terminated, truncated) == (step["terminated"], step["truncated"])
            assert info == step["info"]
        assert env.render() == episode["final_render"]
