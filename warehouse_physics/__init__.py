"""The physics backend."""
