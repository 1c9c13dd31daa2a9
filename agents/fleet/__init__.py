"""Agents for fleets, and shifts that they work."""

from agents.fleet.planned import PlannedFleet
from agents.fleet.shift import run_shift
from agents.fleet.team import Team

__all__ = ["PlannedFleet", "Team", "run_shift"]
