"""Malformed actions are refused or count as invalid; ``bench_env.py`` takes millions."""

import pytest
from helpers.malformed import MAKERS, step_malformed


@pytest.mark.parametrize("backend", ["grid", "physics"])
@pytest.mark.parametrize("name", MAKERS)
def test_malformed_actions_raise_documented_errors_and_change_nothing(
    name: str, backend: str
) -> None:
    tally = step_malformed(name, 3000, 1, backend)
    assert tally.compared > 500
    assert tally.taken == 0 or name == "WarehouseEnv"
