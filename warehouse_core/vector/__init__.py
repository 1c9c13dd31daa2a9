"""Many warehouses at once, in NumPy arrays."""
