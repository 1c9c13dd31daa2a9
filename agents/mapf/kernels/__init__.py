"""Inner loops of the planners: functions on flat buffers that run as plain Python or compiled.

A kernel allocates no memory and never looks at the clock. Its caller makes the buffers, enlarges
them when they are full, and decides when to continue. See ``buffers.py`` for how Numba compiles the
same source.
"""
