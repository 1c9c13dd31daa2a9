"""The tests of commands draw small pictures."""

import pytest


@pytest.fixture(autouse=True)
def small(small_pictures: None) -> None:
    """Use the fixture of all tests for each of these."""
