"""The physics backend: rigid bodies that carry out the moves of the warehouse.

The rules of the warehouse decide what a move means. A motion backend decides where the robot is
afterwards, how long the move takes and what it costs. The backends here simulate each robot as a
round body in pymunk, which is a Python interface to the physics engine Chipmunk. Time advances in
substeps, of 1/60 s by default. Lengths are in metres, x points right (east) and y points down
(south).

The files are best read in this order:

1. ``spec.py``: the numbers that describe a robot, such as its mass and the force of its motor.
2. ``phases.py``: the phases of a drive, as a table.
3. ``robot.py``: the motor and the floor that drags.
4. ``profile.py``: the speed to command and the time to brake, so that a robot stops at its target.
5. ``arena.py``: the space with its walls, and the contacts between bodies.
6. ``giving_way.py``: how robots that block each other get back to their cells.
7. ``energy.py``: what a drive takes from the battery.
8. ``rigid_body_motion.py``: the backend that moves robots cell by cell, from rest to rest.
9. ``driving/``: the backend whose robots drive through cells without stopping in each.
10. ``batch/``: many warehouses at once, with one robot in each.
11. ``drive/``: robots under continuous control, one or thousands of them.

``wheeled_robot.py`` has robots with two driven wheels. ``disturbances.py`` has slippery floors,
weak motors, noise and failures.
"""

# Check the version first: with a wrong one the other imports may fail for another reason.
from warehouse_physics import pymunk_version as _checked  # noqa: F401
from warehouse_physics.disturbances import Disturbances, Stop
from warehouse_physics.driving import DrivingMotion
from warehouse_physics.rigid_body_motion import RigidBodyMotion
from warehouse_physics.spec import RobotSpec

__all__ = ["Disturbances", "DrivingMotion", "RigidBodyMotion", "RobotSpec", "Stop"]
