"""The inner loops of planners: functions on flat buffers that run as they are, or compiled.

A kernel allocates nothing and looks at no clock. Whoever calls it makes the buffers, enlarges them,
and decides when it goes on. See ``buffers.py`` for how the same source is compiled.
"""
