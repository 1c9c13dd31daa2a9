"""Many warehouses, one robot in each, in one pymunk space."""
