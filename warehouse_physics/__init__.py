"""The physics backend: rigid-body robots behind the same ``step``."""

# Check the version first: with a wrong one the other imports may fail for another reason.
from warehouse_physics import pymunk_version as _checked  # noqa: F401
from warehouse_physics.disturbances import Disturbances, Stop
from warehouse_physics.driving import DrivingMotion
from warehouse_physics.rigid_body_motion import RigidBodyMotion
from warehouse_physics.spec import RobotSpec

__all__ = ["Disturbances", "DrivingMotion", "RigidBodyMotion", "RobotSpec", "Stop"]
