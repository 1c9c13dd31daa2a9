"""Exercise 7: what kind of environment is it?

The answers are "fully" or "partially", "deterministic" or "stochastic", "static" or "dynamic",
"discrete" or "continuous", "single" or "multi".
"""

QUESTIONS = ("observable", "chance", "change", "values", "agents")

ANSWERS = {
    # The mini-lab: one robot on the grid. It sees the cells within a view_radius of 2.
    "mini-lab": {
        "observable": "?",
        "chance": "?",
        "change": "?",
        "values": "?",
        "agents": "?",
    },
    # The same with a view_radius of 20: the robot sees the whole layout.
    "wide view": {
        "observable": "?",
        "chance": "?",
        "change": "?",
        "values": "?",
        "agents": "?",
    },
    # The mini-lab with the slippery floor of exercise 21: one move in four slips to a side.
    "slippery": {
        "observable": "?",
        "chance": "?",
        "change": "?",
        "values": "?",
        "agents": "?",
    },
    # Six robots on the grid, each with a view_radius of 2. New orders arrive at random times.
    "fleet": {
        "observable": "?",
        "chance": "?",
        "change": "?",
        "values": "?",
        "agents": "?",
    },
    # One robot with a body and a view_radius of 2: its position, its speed and time are real
    # numbers. Its motors do exactly what they are told.
    "body": {
        "observable": "?",
        "chance": "?",
        "change": "?",
        "values": "?",
        "agents": "?",
    },
}
