"""Agents for fleets."""

from agents.fleet.planned import PlannedFleet
from agents.fleet.team import Team

__all__ = ["PlannedFleet", "Team"]
