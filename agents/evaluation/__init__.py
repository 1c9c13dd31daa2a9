"""How well agents do: scores, intervals and their wording."""
