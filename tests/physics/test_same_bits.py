"""Every backend of bodies gives the same bits in every process and with every hash seed."""

import os
import subprocess
import sys
from contextlib import redirect_stdout
from io import StringIO

PROGRAM = """
import hashlib, random
import numpy as np
from warehouse_core import random_layout
from warehouse_physics import Disturbances, DrivingMotion, RigidBodyMotion

layout, stream = random_layout(7, 9, 0.2, seed=2), random.Random(3)
steps = [(0, 0), (-1, 0), (0, 1), (1, 0), (0, -1)]
cells = [layout.open_cell(rank) for rank in range(len(layout.open_cells))]
rough = Disturbances(0.1, cells[::3], motor_strength=0.9, drag_spread=0.5)

for kind in (RigidBodyMotion, DrivingMotion):
    digest = hashlib.sha256()
    for robots, disturbances in ((1, None), (4, None), (1, rough), (3, rough)):
        motion = kind(disturbances=disturbances)
        motion.reset(layout, cells[:robots], 5)
        for _ in range(6):
            loaded = [stream.random() < 0.5 for _ in range(robots)]
            for outcome in motion.advance(stream.choices(steps, k=robots), loaded):
                digest.update(repr(outcome[:4] + outcome[5:]).encode() + outcome.path.tobytes())
    print(kind.__name__, digest.hexdigest())

digest = hashlib.sha256()
layouts = [random_layout(4 + seed % 5, 9 - seed % 3, 0.2, seed=seed) for seed in range(16)]
batch, draw = RigidBodyMotion().batch(layouts), np.random.default_rng(3)
batch.place(np.arange(16), np.array([layout.open_cells[-1] for layout in layouts]))
for _ in range(20):
    for column in batch.advance(draw.integers(0, 8, 16), draw.random(16) < 0.5)[:4]:
        digest.update(column.tobytes())
print("batch", digest.hexdigest())
"""


def test_outcomes_are_equal_bit_for_bit_in_every_process() -> None:
    with redirect_stdout(StringIO()) as here:
        exec(PROGRAM, {})
    elsewhere = subprocess.run(
        [sys.executable, "-c", PROGRAM],
        env=os.environ | {"PYTHONHASHSEED": "4242"},
        capture_output=True,
        check=True,
        text=True,
    ).stdout
    assert here.getvalue() == elsewhere
    assert len(elsewhere.splitlines()) == 3
