"""Steps POGEMA in a process of its own; it needs older versions of what it shares with this one.

Reads a line of JSON with ``map``, ``starts`` and ``actions``, and then numbers of steps; for each
it writes the seconds by the clock and of the processor.
"""

import json
import sys
import time

from pogema import GridConfig, pogema_v0


def main() -> None:
    given = json.loads(sys.stdin.readline())
    config = GridConfig(
        map="\n".join(given["map"]),
        agents_xy=given["starts"],
        targets_xy=given["targets"],
        num_agents=len(given["starts"]),
        obs_radius=2,
        collision_system="soft",
        on_target="nothing",
        max_episode_steps=10**9,
        seed=0,
    )
    env, actions, number = pogema_v0(config), given["actions"], 0
    env.reset()
    for line in sys.stdin:
        wall, cpu = time.perf_counter(), time.process_time()
        for _ in range(int(line)):
            env.step(actions[number % len(actions)])
            number += 1
        print(time.perf_counter() - wall, time.process_time() - cpu, flush=True)


if __name__ == "__main__":
    main()
