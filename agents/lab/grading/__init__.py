"""Grades of agents: a rubric, episodes in processes of their own, and reports."""
