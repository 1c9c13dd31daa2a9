"""Fleets on the grid and on bodies, in five worlds, for ``warehouse compare backends``."""
