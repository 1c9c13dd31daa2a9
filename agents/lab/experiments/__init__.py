"""Experiments: many episodes under many settings, stored as they finish."""
