"""Agents for the warehouse, the episode runner and the command line."""
