"""Lone robots, each on a floor of its own."""
