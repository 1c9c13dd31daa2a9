"""Exports and replays compared with plain matplotlib animations."""

import subprocess
import sys


def test_a_gif_of_a_physics_episode_is_small_in_memory(measured, tmp_path):
    """Measure the time without imports, and the peak memory of the whole process."""
    program = f"""
import re, time
from pathlib import Path
from agents.run_episode import run_episode
from warehouse_core.warehouse_viz import replay_animation
import warehouse_core.viz.replay
episode = run_episode(seed=2, backend="physics")
start = time.perf_counter()
replay_animation(episode, window=False).save({str(tmp_path / "film.gif")!r})
spent = time.perf_counter() - start
# The peak of getrusage would include the memory of the process that started this one.
peak = re.search(r"VmHWM:\\s*(\\d+)", Path("/proc/self/status").read_text())[1]
print(spent, int(peak) / 1024)
"""
    words = [sys.executable, "-c", program]
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    spent, megabytes = map(float, done.stdout.split())
    size = (tmp_path / "film.gif").stat().st_size / 1e6
    found = f"{spent:.1f} s, {megabytes:.0f} MB of memory, a file of {size:.1f} MB"
    measured("a GIF of 134 steps of physics", found)
    assert megabytes < 300
