"""A random agent searches the ice cream cone.

Usage: python random_agent.py [SCENARIO]
"""

import sys
from pathlib import Path

import gymnasium as gym

import dragnet  # noqa: F401 - registers the environment

SCENARIO = Path(__file__).resolve().parents[2] / "scenarios/ice_cream_cone.toml"


def main(scenario=SCENARIO, seed=0):
    env = gym.make("dragnet/Search-v0", scenario=scenario, control="step", reward="found")
    env.action_space.seed(seed)
    _, info = env.reset(seed=seed)
    found, over = 0.0, False
    while not over:
        action = env.action_space.sample(mask=info["action_mask"])
        _, reward, terminated, truncated, info = env.step(action)
        found += reward
        over = terminated or truncated
    print(f"{found:.0f} objects found on {info['path_cells']:.0f} cells driven: recall {info['recall']:.2f}")
    return info


if __name__ == "__main__":
    main(*sys.argv[1:])
