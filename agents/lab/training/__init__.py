"""Trainings watched: exams of the agent, and the picture of its learning curve."""
