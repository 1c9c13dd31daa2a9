"""Multi-agent path finding (MAPF): planners that find paths without conflicts for many robots.

The terms follow Stern et al. (2019), Multi-agent pathfinding: definitions, variants, and
benchmarks.
"""
