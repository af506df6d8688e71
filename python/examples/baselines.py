"""Our policies in the loop: one episode by hand, and a comparison over seeds.

Usage: python baselines.py [SCENARIO]
"""

import sys
from pathlib import Path

import dragnet

SCENARIO = Path(__file__).resolve().parents[2] / "scenarios/ice_cream_cone.toml"


def play(scenario, name, seed):
    """An episode in which a policy decides; returns how it ended."""
    env = dragnet.SearchEnv(scenario)
    policy = dragnet.Policy(name, env.scenario, seed=seed)
    _, info = env.reset(seed=seed)
    over = False
    while not over:
        decision = policy(env.belief())
        _, _, terminated, truncated, info = env.step(decision.waypoint)
        over = terminated or truncated
    return info


def main(scenario=SCENARIO, seeds=10):
    for name in ("path", "greedy", "nats", "gnn", "random"):
        info = play(scenario, name, seed=0)
        print(f"{name:>8}: all found on {info['path_cells']:.0f} cells, F1 {info['f1']:.2f}")
    table = dragnet.compare(scenario, ["path", "greedy", "random"], seeds=seeds, robots=1)
    print(table.to_csv())
    return table


if __name__ == "__main__":
    main(*sys.argv[1:])
