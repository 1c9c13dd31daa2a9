"""Many warehouses in one pymunk space, with one robot in each."""

from warehouse_physics.batch.rigid_body_batch import RigidBodyBatch

__all__ = ["RigidBodyBatch"]
