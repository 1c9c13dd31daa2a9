"""The kinds of agents, a file each: reflex, model-based, goal-based and utility-based.

The fifth kind, which learns, is in ``agents/learning``. Each class is short, to be changed.

Source: Russell and Norvig, 4th ed., section 2.4.
"""
