"""The task of a robot: rules, starts, observations, settings."""
