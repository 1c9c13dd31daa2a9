"""Fleets on the grid and on bodies, in four worlds, for ``warehouse compare backends``."""
