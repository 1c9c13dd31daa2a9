"""Datasets of episodes for offline learning, in the files of Minari."""
