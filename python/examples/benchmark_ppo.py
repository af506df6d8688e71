"""MaskablePPO of sb3-contrib learns on the maps of the benchmark's track "single"; then it is measured there.

Usage: python benchmark_ppo.py [MINUTES] [RESULT]

It needs sb3-contrib. Network and settings are those of ppo.py. It learns from searches with other seeds than the track's, of all four
maps and both densities in turn.
"""

import sys

import numpy as np
import torch
from ppo import CHOICES, Batched, Crop, Lanes, Learned, Until
from sb3_contrib import MaskablePPO

import dragnet

MAPS = ("ice_cream_cone", "open_asterisk", "figure_four", "all_traversable")
DENSITIES = (0.01, 0.2)
BUDGET_CELLS = 300


class Together(Lanes):
    """Vector environments of several scenarios, side by side."""

    def __init__(self, parts):
        self.parts = parts
        self.render_mode = None
        count = sum(part.num_envs for part in parts)
        super().__init__(count, parts[0].observation_space, parts[0].action_space)

    def reset(self):
        return np.concatenate([part.reset() for part in self.parts])

    def step_async(self, actions):
        for part, own in zip(self.parts, np.split(actions, len(self.parts)), strict=True):
            part.step_async(own)

    def step_wait(self):
        observations, rewards, over, infos = zip(*(part.step_wait() for part in self.parts), strict=True)
        return np.concatenate(observations), np.concatenate(rewards), np.concatenate(over), sum(infos, [])

    def env_method(self, method_name, *arguments, indices=None, **named):
        return sum((part.env_method(method_name, *arguments, **named) for part in self.parts), [])

    def has_attr(self, attr_name):
        return self.parts[0].has_attr(attr_name)

    def close(self):
        for part in self.parts:
            part.close()


def environments(lanes, seed):
    parts = []
    for name in MAPS:
        for density in DENSITIES:
            scenario = dragnet.Scenario.load(f"paper/{name}").with_density(density).with_budget_cells(BUDGET_CELLS)
            part = Batched(dragnet.SearchVectorEnv(scenario, lanes, masked_action="error", **CHOICES))
            part.seed(seed + 100_000 * len(parts))
            parts.append(part)
    return parts


def learn(minutes, lanes, seed=1_000_000):
    torch.set_num_threads(1)
    parts = environments(lanes, seed)
    model = MaskablePPO(
        "CnnPolicy",
        Together(parts),
        n_steps=64,
        batch_size=512,
        n_epochs=4,
        learning_rate=5e-4,
        gamma=0.95,
        gae_lambda=0.9,
        ent_coef=0.01,
        policy_kwargs={
            "features_extractor_class": Crop,
            "features_extractor_kwargs": {"robot": parts[0].envs.features.index("robot")},
            "normalize_images": False,
            "net_arch": [64],
        },
        seed=seed,
    )
    model.learn(10**9, callback=Until(60 * minutes))
    print(f"{model.num_timesteps:,} steps learned from")
    return model


def main(minutes=10.0, out=None, track="single", lanes=8):
    result = dragnet.benchmark.run(track, {"ppo": Learned(learn(minutes, lanes))}, out=out, **CHOICES)
    for row in result.summary:
        cells, sem = row["cells_to_full_recall_restricted_mean"], row["cells_to_full_recall_restricted_sem"]
        print(f"{row['group']:>22}: {cells:.1f} ± {sem:.1f} cells, {row['reached']} of {row['episodes']} reached")
    return result


if __name__ == "__main__":
    main(*map(float, sys.argv[1:2]), *sys.argv[2:3])
