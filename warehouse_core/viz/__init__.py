"""Figures and animations, by matplotlib."""
