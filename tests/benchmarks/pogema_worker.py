"""A program that steps POGEMA in a separate process, because POGEMA needs older packages.

It reads a line of JSON with ``map``, ``starts`` and ``actions``, and then numbers of steps. For
each number it writes the wall-clock time and the CPU time in seconds.
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
    # The class itself, without the wrappers that limit episodes and measure them.
    env, actions, number = pogema_v0(config).unwrapped, given["actions"], 0
    env.reset()
    for line in sys.stdin:
        wall, cpu = time.perf_counter(), time.process_time()
        for _ in range(int(line)):
            env.step(actions[number % len(actions)])
            number += 1
        print(time.perf_counter() - wall, time.process_time() - cpu, flush=True)


if __name__ == "__main__":
    main()
