"""Exercise 21: a slippery floor."""

MOVES = {"N": (-1, 0), "E": (0, 1), "S": (1, 0), "W": (0, -1)}
SLIP, STEP, BUMP, SWEEPS = 0.25, -0.1, -1.0, 100


class Sure:
    def reset(self):
        self.cells, self.policy, self.goal = set(), {}, None

    def act(self, observation):
        here, has_item = observation["robot_pos"], observation["has_item"]
        goal = observation["dropoff_pos"] if has_item else observation["pickup_pos"]
        if here == goal:
            return "DROP" if has_item else "PICK"
        radius = len(observation["local_grid"]) // 2
        for down, line in enumerate(observation["local_grid"]):
            for right, tile in enumerate(line):
                if tile != "#":
                    self.cells.add((here[0] + down - radius, here[1] + right - radius))
        if goal != self.goal:
            self.goal, self.policy = goal, self.best_moves(goal)
        return self.policy[here]

    def best_moves(self, goal):
        """Return the move with the highest expected utility for each cell, by value iteration."""
        value = dict.fromkeys(self.cells, 0.0)

        def worth(cell, move):
            there = cell[0] + move[0], cell[1] + move[1]
            return STEP + (value[there] if there in value else BUMP + value[cell])

        def utility(cell, name):
            down, right = MOVES[name]
            sides = worth(cell, (right, -down)) + worth(cell, (-right, down))
            return (1 - SLIP) * worth(cell, (down, right)) + SLIP / 2 * sides

        for _ in range(SWEEPS):
            for cell in self.cells - {goal}:
                value[cell] = max(utility(cell, name) for name in MOVES)
        return {cell: max(MOVES, key=lambda name: utility(cell, name)) for cell in self.cells}
