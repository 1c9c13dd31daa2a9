"""The physics backend: every grid move as a rigid-body motion, behind the same ``step``."""

# The version is checked first, so that a wrong one is not met by what it lacks.
from warehouse_physics import pymunk_version as _checked  # noqa: F401
from warehouse_physics.disturbances import Disturbances
from warehouse_physics.motion import RigidBodyMotion
from warehouse_physics.robot_spec import RobotSpec

__all__ = ["Disturbances", "RigidBodyMotion", "RobotSpec"]
