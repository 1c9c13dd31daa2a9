"""Trials of an agent in an environment with a seed, and their rows, scores and intervals."""
