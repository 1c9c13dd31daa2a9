"""Many warehouses, one robot in each, in one pymunk space."""

from warehouse_physics.batch.rigid_body_batch import RigidBodyBatch

__all__ = ["RigidBodyBatch"]
