"""Many warehouses, one robot in each, in one pymunk space."""

from warehouse_physics.vector.motion import RigidBodyBatch

__all__ = ["RigidBodyBatch"]
