"""Support for training agents: exams, learning curves and checkpoints."""
