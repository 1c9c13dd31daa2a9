"""Analysis of results: what differs, how cases compare, and sentences about it."""
