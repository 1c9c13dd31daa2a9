"""Export of episodes as Minari datasets, MCAP recordings and CSV tables."""
