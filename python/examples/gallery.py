"""A picture of each registered environment: a search by ``tour`` after half of its path.

Usage: python gallery.py FOLDER
"""

import sys
from pathlib import Path

import gymnasium as gym
from PIL import Image

import dragnet


def main(folder, names=None, seed=3):
    """Draws the environments of these names, or all; a file each."""
    registered = {spec.name for spec in gym.registry.values() if spec.namespace == "dragnet"}
    # Search is IceCreamCone, until it is made with a scenario of your own.
    for name in names or sorted(registered - {"Search"}):
        env = gym.make(f"dragnet/{name}-v0", control="step", render_mode="rgb_array").unwrapped
        picture = Image.fromarray(search(env, seed))
        # Few colors: a small file.
        picture.quantize(64).save(Path(folder) / f"{name}.png", optimize=True)


def search(env, seed):
    policy = dragnet.Policy("tour", env.scenario, seed=seed)
    env.reset(seed=seed)
    pictures, over = [], False
    while not over:
        decision = policy(env.belief())
        env.show_plan(decision.path)
        pictures.append(env.render())
        _, _, terminated, truncated, _ = env.step(decision.step)
        over = terminated or truncated
    return pictures[len(pictures) // 2]


if __name__ == "__main__":
    main(*sys.argv[1:])
