"""Experiments that run many episodes under many settings and store each one as it finishes."""
