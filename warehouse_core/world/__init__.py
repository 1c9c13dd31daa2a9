"""The world that a robot is in: tiles, layouts, generators, map files."""
