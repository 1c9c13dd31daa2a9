"""Robots that drive through the cells of their ways, and brake only where they must."""

from warehouse_physics.driving.driving_motion import DrivingMotion

__all__ = ["DrivingMotion"]
