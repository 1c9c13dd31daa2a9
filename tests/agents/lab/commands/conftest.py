"""The tests of commands draw small pictures."""

import pytest


@pytest.fixture(autouse=True)
def small(small_pictures: None) -> None:
    """Use ``small_pictures`` in every test of this folder."""
