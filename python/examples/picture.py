"""A picture of a run with matplotlib: the belief, the way and the objects, and how F1 grew.

Usage: python picture.py OUTPUT.png [SCENARIO]
"""

import sys
from pathlib import Path

import matplotlib

matplotlib.use("agg")

import matplotlib.pyplot as plt
import numpy as np

import dragnet

SCENARIO = Path(__file__).resolve().parents[2] / "scenarios/ice_cream_cone.toml"


def main(output, scenario=SCENARIO, seed=0):
    env = dragnet.SearchEnv(scenario, reward="f1")
    policy = dragnet.Policy("path", env.scenario, seed=seed)
    _, info = env.reset(seed=seed)
    curve, over = [(0.0, info["f1"])], False
    while not over:
        _, _, terminated, truncated, info = env.step(policy(env.belief()).waypoint)
        curve.append((info["path_cells"], info["f1"]))
        over = terminated or truncated
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.5), layout="constrained")
    ground = np.where(env.scenario.traversable, env.belief()["probability"], np.nan)
    shown = left.imshow(ground, origin="lower", cmap="magma_r", vmin=0, vmax=1)
    figure.colorbar(shown, ax=left, label="probability of an object")
    rows, columns = np.divmod(env.path, env.scenario.shape[1])
    left.plot(columns, rows, color="tab:blue", linewidth=1)
    rows, columns = np.divmod(env.objects, env.scenario.shape[1])
    left.scatter(columns, rows, s=60, facecolors="none", edgecolors="tab:green")
    left.set(xlabel="column", ylabel="row", title=f"{env.scenario.name}, seed {seed}")
    right.step(*zip(*curve, strict=True), where="post")
    right.set(xlabel="way, cells", ylabel="F1", ylim=(0, 1.05))
    figure.savefig(output, dpi=120)
    plt.close(figure)


if __name__ == "__main__":
    main(*sys.argv[1:])
