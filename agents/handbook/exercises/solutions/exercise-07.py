"""Exercise 7: what kind of environment is it?"""

ANSWERS = {
    "mini-lab": {
        "observable": "partially",
        "chance": "deterministic",
        "change": "static",
        "values": "discrete",
        "agents": "single",
    },
    "wide view": {
        "observable": "fully",
        "chance": "deterministic",
        "change": "static",
        "values": "discrete",
        "agents": "single",
    },
    "slippery": {
        "observable": "partially",
        "chance": "stochastic",
        "change": "static",
        "values": "discrete",
        "agents": "single",
    },
    "fleet": {
        "observable": "partially",
        "chance": "stochastic",
        "change": "dynamic",
        "values": "discrete",
        "agents": "multi",
    },
    "body": {
        "observable": "partially",
        "chance": "deterministic",
        "change": "static",
        "values": "continuous",
        "agents": "single",
    },
}
