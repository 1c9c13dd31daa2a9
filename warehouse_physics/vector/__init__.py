"""Many warehouses in one pymunk space."""
