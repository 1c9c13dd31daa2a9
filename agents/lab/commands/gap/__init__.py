"""The command ``warehouse gap``: what bodies do of what a plan on the grid promises."""
