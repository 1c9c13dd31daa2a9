"""Exercise 7: what kind of environment is it?

Answers are "fully" or "partially", "deterministic" or "stochastic", "static" or "dynamic",
"discrete" or "continuous", "single" or "multi".
"""

QUESTIONS = ("observable", "chance", "change", "values", "agents")

ANSWERS = {
    # The mini-lab: one robot that sees two cells far, on the grid.
    "mini-lab": {
        "observable": "?",
        "chance": "?",
        "change": "?",
        "values": "?",
        "agents": "?",
    },
    # The same with a view_radius of 20: the robot sees the whole floor.
    "wide view": {
        "observable": "?",
        "chance": "?",
        "change": "?",
        "values": "?",
        "agents": "?",
    },
    # One robot on the grid of exercise 21: one move in four goes to a side.
    "slippery": {
        "observable": "?",
        "chance": "?",
        "change": "?",
        "values": "?",
        "agents": "?",
    },
    # Six robots on the grid; new orders come at random while they think; they see two cells far.
    "fleet": {
        "observable": "?",
        "chance": "?",
        "change": "?",
        "values": "?",
        "agents": "?",
    },
    # One robot with a body: place, speed and time are numbers; it sees two cells far, motors obey.
    "body": {
        "observable": "?",
        "chance": "?",
        "change": "?",
        "values": "?",
        "agents": "?",
    },
}
