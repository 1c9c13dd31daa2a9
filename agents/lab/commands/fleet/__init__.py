"""The command ``warehouse fleet``, and its options and measures, which other commands use."""
