"""The command ``warehouse fleet`` and its report of shifts."""
