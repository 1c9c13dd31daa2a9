"""What the episodes of an experiment say, in numbers and in sentences."""
