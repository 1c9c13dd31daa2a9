"""Planners of several robots: the way of each, so that no two meet.

The words are from multi-agent path finding (MAPF): see Stern et al. (2019),
Multi-agent pathfinding: definitions, variants, and benchmarks.
"""
