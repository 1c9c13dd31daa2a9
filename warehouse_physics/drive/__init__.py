"""Continuous control: the same warehouse, driven by velocities, wheel speeds or forces.

``DriveEnv`` is ``WarehouseDrive-v0``, and ``DriveVectorEnv`` is its vector form. The files are best
read in this order:

1. ``drives.py``: the force with which each kind of drive answers a command.
2. ``bodies.py``: the bodies in pymunk, which forces push.
3. ``rows.py``: the task, its rewards and its ends, for one or many warehouses.
4. ``observations.py``: what a robot observes.
5. ``env.py`` and ``vector.py``: the interfaces of Gymnasium.
6. ``things.py``: crates, obstacles and bodies of users.
7. ``recording.py``: records of episodes, which the usual painters draw.
"""

from warehouse_physics.drive.env import DriveEnv
from warehouse_physics.drive.vector import DriveVectorEnv

__all__ = ["DriveEnv", "DriveVectorEnv"]
