"""Comparison of a fleet on the grid and on rigid bodies, for ``warehouse compare backends``."""
