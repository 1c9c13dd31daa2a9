"""What the results of an experiment say: tests, pictures, examples, one page."""
