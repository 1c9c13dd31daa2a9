"""The commands that measure planners of several robots."""
