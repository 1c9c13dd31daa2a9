"""The command ``warehouse grade``."""
