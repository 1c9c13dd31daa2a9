"""A program that steps VMAS in a separate process, because VMAS needs PyTorch.

Its arguments are the number of environments and of rays. The scenario is ``navigation`` with two
agents, since a lone agent has nothing that its rays could meet. It reads numbers of steps, and for
each it writes the CPU time in seconds of this many steps.
"""

import sys
import time

import torch
import vmas


def main() -> None:
    envs, rays = map(int, sys.argv[1:])
    torch.set_num_threads(1)
    scenario = {"n_agents": 2, "collisions": rays > 0, "n_lidar_rays": max(rays, 1)}
    env = vmas.make_env("navigation", num_envs=envs, continuous_actions=True, seed=0, **scenario)
    env.reset()
    actions = [torch.rand(envs, 2) * 2 - 1 for _ in range(2)]
    for line in sys.stdin:
        start = time.process_time()
        for _ in range(int(line)):
            env.step(actions)
        print(time.process_time() - start, flush=True)


if __name__ == "__main__":
    main()
