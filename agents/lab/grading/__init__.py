"""Grading of agents: rubrics, agents in isolated processes, and reports."""
