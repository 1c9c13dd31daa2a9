"""``render_mode="human"`` on a real display. Run with ``pytest -m window``."""

from collections.abc import Callable

import pytest
from helpers.windows import Shower

pytestmark = pytest.mark.window

Start = Callable[..., Shower]

WALK = """
import gymnasium
env = gymnasium.make(
    "warehouse_core.gymnasium_env:Warehouse-v0", render_mode="human", randomize=False, max_steps=400
)
env.reset(seed=0)
print(env.render())
over = False
for step in range(400):
    *_, over, _ = env.step(step % 4)
    print("closed" if env.unwrapped._window.is_closed else "open", flush=True)
    if env.unwrapped._window.is_closed:
        break
env.reset()
env.step(0)
env.close()
env.close()
print("ended")
"""


def test_an_episode_continues_after_its_window_is_closed(start: Start) -> None:
    program = start(WALK)
    program.wait_for("None")
    program.wait_for("open", 3)
    program.ask_to_close(program.focus())
    program.wait_for("closed")
    assert program.rest() == ["ended"]
    assert program.code() == 0


def test_closing_the_environment_closes_its_window(start: Start) -> None:
    wait = "import time; print('after close', flush=True); time.sleep(60)"
    program = start(WALK.replace("range(400)", "range(9)") + wait)
    program.wait_for("open")
    assert len(program.windows()) == 1
    program.wait_for("after close")
    assert program.windows() == []
