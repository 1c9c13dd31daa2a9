"""Search: algorithms, problems, heuristics, and agents that plan."""
