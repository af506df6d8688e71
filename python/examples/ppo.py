"""MaskablePPO of sb3-contrib learns to search the ice cream cone from planes; then it is compared with built-in policies.

Usage: python ppo.py [MINUTES]

It needs sb3-contrib. A small convolutional network sees the map around the robot, and steps to a neighbor.
"""

import sys
import time

import gymnasium as gym
import torch
from sb3_contrib import MaskablePPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor
from stable_baselines3.common.vec_env import VecEnv

import dragnet

ID = "dragnet/IceCreamCone-v0"
CHOICES = {"control": "step", "observation": "planes"}


class Crop(BaseFeaturesExtractor):
    """The cells around the robot in full, and all of the map in blocks of 5 x 5 cells, seen from the robot too."""

    def __init__(self, observation_space, robot, reach=7):
        super().__init__(observation_space, features_dim=128)
        channels, rows, columns = observation_space.shape
        self.robot, self.reach, self.columns = robot, reach, columns
        side = 2 * reach + 1
        self.blocks = torch.nn.AvgPool2d(5, ceil_mode=True)
        self.far_reach = (max(rows, columns) + 4) // 5
        self.near = torch.nn.Sequential(
            torch.nn.Conv2d(channels, 16, 3, padding=1),
            torch.nn.ReLU(),
            torch.nn.Conv2d(16, 16, 3, stride=2, padding=1),
            torch.nn.ReLU(),
            torch.nn.Flatten(),
        )
        near = 16 * ((side + 1) // 2) ** 2
        far = channels * (2 * self.far_reach + 1) ** 2
        self.join = torch.nn.Sequential(torch.nn.Linear(near + far, 128), torch.nn.ReLU())

    def forward(self, planes):
        cell = planes[:, self.robot].flatten(1).argmax(1)
        row, column = cell // self.columns, cell % self.columns
        near = self.near(around(planes, row, column, self.reach))
        far = around(self.blocks(planes), row // 5, column // 5, self.far_reach).flatten(1)
        return self.join(torch.cat([near, far], dim=1))


def around(planes, row, column, reach):
    """The cells up to ``reach`` around each robot's, zeros beyond the edge: shape ``(lanes, channels, side, side)``."""
    side = 2 * reach + 1
    windows = torch.nn.functional.pad(planes, (reach,) * 4).unfold(2, side, 1).unfold(3, side, 1)
    return windows[torch.arange(len(planes)), :, row, column]


class Lanes(VecEnv):
    """What Stable-Baselines3 asks of environments that are all alike."""

    def get_attr(self, attr_name, indices=None):
        return [getattr(self, attr_name)] * self.num_envs

    def set_attr(self, attr_name, value, indices=None):
        raise NotImplementedError

    def env_is_wrapped(self, wrapper_class, indices=None):
        return [False] * self.num_envs


class Batched(Lanes):
    """Our vector environment as Stable-Baselines3 wants its own: an episode that is over begins anew in the same step."""

    def __init__(self, envs):
        self.envs = envs
        self.render_mode = None
        super().__init__(envs.num_envs, envs.single_observation_space, envs.single_action_space)

    def reset(self):
        observation, self.told = self.envs.reset(seed=self._seeds[0])
        return observation.copy()

    def step_async(self, actions):
        self.actions = actions

    def step_wait(self):
        observation, reward, terminated, truncated, self.told = self.envs.step(self.actions)
        over = terminated | truncated
        infos = [{} for _ in over]
        if over.any():
            for lane in over.nonzero()[0]:
                infos[lane] = {"terminal_observation": observation[lane].copy(), "TimeLimit.truncated": truncated[lane]}
            observation, self.told = self.envs.reset(options={"reset_mask": over})
        return observation.copy(), reward, over, infos

    def env_method(self, method_name, *arguments, indices=None, **named):
        return list(getattr(self.envs, method_name)(*arguments, **named))

    def has_attr(self, attr_name):
        return hasattr(self.envs, attr_name)

    def close(self):
        self.envs.close()


class Until(BaseCallback):
    """Ends the learning at a time, and after an update at least."""

    def __init__(self, seconds):
        super().__init__()
        self.end = time.monotonic() + seconds

    def _on_step(self):
        return time.monotonic() < self.end or self.model._n_updates == 0


def learn(minutes, lanes, seed=1_000_000):
    """Learns on other episodes than those of the comparison, whose seeds are small."""
    # Threads of PyTorch wait for each other wherever something else uses a core: so small a network loses by them.
    torch.set_num_threads(1)
    envs = Batched(gym.make_vec(ID, num_envs=lanes, masked_action="error", **CHOICES).unwrapped)
    envs.seed(seed)
    model = MaskablePPO(
        "CnnPolicy",
        envs,
        n_steps=128,
        batch_size=512,
        n_epochs=4,
        learning_rate=5e-4,
        gamma=0.95,
        gae_lambda=0.9,
        ent_coef=0.01,
        policy_kwargs={
            "features_extractor_class": Crop,
            "features_extractor_kwargs": {"robot": envs.envs.features.index("robot")},
            "normalize_images": False,
            "net_arch": [64],
        },
        seed=seed,
    )
    model.learn(10**9, callback=Until(60 * minutes))
    print(f"{model.num_timesteps:,} steps learned from")
    return model


class Learned:
    """A model as a policy. It draws its actions: the most probable ones may lead to and fro for ever."""

    def __init__(self, model):
        self.model = model

    def reset(self, seed):
        torch.manual_seed(seed)

    def __call__(self, observation, action_mask):
        return self.model.predict(observation, action_masks=action_mask)[0]


def main(minutes=10.0, seeds=100, lanes=32):
    policies = {"ppo": Learned(learn(minutes, lanes)), "greedy": "greedy", "random": "random"}
    table = dragnet.compare("ice_cream_cone", policies, seeds=seeds, robots=1, **CHOICES)
    for row in table:
        cells, found = row["cells_to_full_recall_restricted_mean"], row["cells_to_full_recall_reached"]
        print(
            f"{row['policy']:>7}: all found on {cells:.0f} cells in the restricted mean, in {found} of {seeds} searches"
        )
    for row in table.differences:
        low, high = row["cells_to_full_recall_low"], row["cells_to_full_recall_high"]
        print(f"{row['policy']:>7} less ppo: {low:+.0f} to {high:+.0f} cells, 95 % interval")
    return table


if __name__ == "__main__":
    main(*map(float, sys.argv[1:2]))
