"""Fleets, each with several robots on a floor of its own, and with orders and people."""
