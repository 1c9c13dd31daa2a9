"""The seam between the rules and what carries out a move, and the grid backend."""
