"""Figures, animations, pages and drawings that show episodes."""
