"""Robots that drive through cells and brake only where they must.

In ``RigidBodyMotion`` each robot stops in every cell. Here a robot has a route, which is a sequence
of neighbouring cells. It drives each straight part of the route, a *leg*, at up to its top speed.
It begins to turn into the next leg while it still brakes in the old direction, and so cuts the
corner. It stops where its route ends or turns back, and where it has to wait for another robot.

Robots do not need to arrive at a given time. They only have to pass each cell in the right order,
however late they are. A robot may therefore enter a cell as soon as the robot that passes it
before, its *leader* in this cell, is far enough beyond the middle. Until then it stops before the
cell, or follows its leader at a distance from which it could still stop if the leader braked as
hard as possible.

The files are best read in this order:

1. ``dependencies.py``: the routes, and which robot passes each cell before which.
2. ``limits.py``: how fast each robot can speed up, brake and turn corners.
3. ``leaders.py``: the distances to leaders, and the speeds that keep them.
4. ``driver.py``: the speed of each robot in each substep.
5. ``motors.py``, ``headings.py`` and ``wheels.py``: what floors, noise, turns and wheels make of
   the commanded speeds.
6. ``driving_motion.py``: the backend, which extends the routes by the actions of a fleet.
"""

from warehouse_physics.driving.driving_motion import DrivingMotion

__all__ = ["DrivingMotion"]
