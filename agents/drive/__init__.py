"""Agents for continuous control: a follower that drives the moves of any grid agent."""

from agents.drive.follower import Follower

__all__ = ["Follower"]
