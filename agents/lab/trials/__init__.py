"""One trial: an environment, an agent and a seed; the rows, scores and intervals it gives."""
