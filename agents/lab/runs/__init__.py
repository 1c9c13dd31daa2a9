"""Runs of agents in environments, and the names of the programs that ran them."""
