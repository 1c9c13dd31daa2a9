"""Agents for fleets, and shifts that they work."""

from agents.fleet.agents import FleetAgent, Team

__all__ = ["FleetAgent", "Team"]
