"""A display for the tests that open windows."""

import os
import shutil
import subprocess
from collections.abc import Iterator

import pytest
from helpers.windows import stop


@pytest.fixture(scope="module")
def display() -> Iterator[str]:
    """Yield the name of a new X display."""
    for program in ("Xvfb", "xdotool"):
        if shutil.which(program) is None:
            pytest.fail(f"{program} is not installed, and window tests need it (xvfb, xdotool)")
    reading, writing = os.pipe()
    # Without -noreset it restarts whenever its last client disconnects.
    options = ["-screen", "0", "1400x1000x24", "-nolisten", "tcp", "-noreset"]
    server = subprocess.Popen(
        ["Xvfb", "-displayfd", str(writing), *options],
        pass_fds=[writing],
        stderr=subprocess.DEVNULL,
    )
    try:
        os.close(writing)
        with open(reading, encoding="ascii") as pipe:
            number = pipe.readline().strip()
        assert number, "Xvfb did not start"
        yield f":{number}"
    finally:
        stop(server)
