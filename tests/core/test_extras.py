"""Commands that install what an optional part needs."""

import pytest

from warehouse_core.extras import install_command


@pytest.mark.parametrize(
    ("extra", "packages"),
    [("physics", ["pymunk"]), ("rl", ["sb3-contrib", "stable-baselines3"]), ("fast", ["numba"])],
)
def test_the_command_names_the_packages_of_an_extra_and_no_other(extra, packages) -> None:
    command = install_command(extra)
    assert command.startswith("pip install '")
    requirements = command.removeprefix("pip install ").split()
    assert [
        each.strip("'").partition(">")[0].partition("<")[0] for each in requirements
    ] == packages
