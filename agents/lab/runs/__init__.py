"""Runs of agents in environments, and names of the program that ran them."""
