"""What others have written for Gymnasium and PettingZoo works as its users write it."""

import warnings

import gymnasium as gym
import numpy as np
import pytest
import torch
from conftest import masked_sample, small
from gymnasium.utils.env_checker import data_equivalence
from gymnasium.vector import AsyncVectorEnv, SyncVectorEnv
from gymnasium.wrappers import (
    DtypeObservation,
    FlattenObservation,
    NormalizeObservation,
    NormalizeReward,
    RecordEpisodeStatistics,
    RecordVideo,
    TimeLimit,
)
from pettingzoo.test import api_test
from pettingzoo.utils import aec_to_parallel, parallel_to_aec
from sb3_contrib import MaskablePPO
from sb3_contrib.common.maskable.evaluation import evaluate_policy
from sb3_contrib.common.maskable.utils import get_action_masks, is_masking_supported
from stable_baselines3 import A2C, DQN, PPO
from stable_baselines3.common.env_checker import check_env as stable_baselines_check
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.vec_env import DummyVecEnv, VecNormalize

import dragnet


def make(**choices):
    return gym.make("dragnet/Search-v0", scenario=small(budget_cells=40), control="step", **choices)


@pytest.fixture(autouse=True)
def few_threads():
    torch.set_num_threads(1)
    torch.manual_seed(0)


def check_steps(env, steps=60):
    """Steps at random; everything that is observed is finite and in its space."""
    random = np.random.default_rng(0)
    observation, _ = env.reset(seed=3)
    ends = 0
    for _ in range(steps):
        flat = observation.values() if isinstance(observation, dict) else [observation]
        assert all(np.isfinite(part).all() for part in flat)
        assert observation in env.observation_space
        observation, reward, terminated, truncated, _ = env.step(int(random.integers(4)))
        assert np.isfinite(reward)
        if terminated or truncated:
            observation, _ = env.reset()
            ends += 1
    assert ends > 0


@pytest.mark.parametrize("kind", ["dict", "graph"])
def test_observations_are_flattened_and_normalized(kind):
    check_steps(FlattenObservation(make(observation=kind)))
    check_steps(NormalizeObservation(DtypeObservation(FlattenObservation(make(observation=kind)), np.float32)))


def test_planes_are_normalized():
    check_steps(NormalizeReward(NormalizeObservation(make(observation="planes"))))
    check_steps(TimeLimit(RecordEpisodeStatistics(make(observation="planes")), 10))


def test_videos_are_recorded(tmp_path):
    env = RecordVideo(make(render_mode="rgb_array"), str(tmp_path), episode_trigger=lambda episode: True)
    check_steps(env)
    env.close()
    assert len(list(tmp_path.glob("*.mp4"))) >= 1


@pytest.mark.parametrize("kind", ["dict", "planes", "graph"])
@pytest.mark.parametrize("vector", [SyncVectorEnv, AsyncVectorEnv])
def test_vector_environments_of_others_go_through_the_same_episodes_as_ours(vector, kind):
    ours = dragnet.SearchVectorEnv(small(budget_cells=40), 2, control="step", observation=kind)
    theirs = vector([lambda: make(observation=kind)] * 2)
    (seen, info), (expected, _) = ours.reset(seed=5), theirs.reset(seed=5)
    random = np.random.default_rng(0)
    for _ in range(50):
        assert data_equivalence(seen, expected, exact=True)
        actions = np.array([masked_sample(mask, random) for mask in info["action_mask"]])
        seen, rewards, _, _, info = ours.step(actions)
        expected, expected_rewards, *_ = theirs.step(actions)
        assert np.array_equal(rewards, expected_rewards)
    theirs.close()


def test_stable_baselines_accepts_the_environment():
    for kind in ("dict", "planes"):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            # That these are no pictures of uint8 is no fault: `normalize_images=False` says it.
            warnings.filterwarnings("ignore", message=".*image.*")
            stable_baselines_check(make(observation=kind).unwrapped)


@pytest.mark.parametrize("algorithm", [PPO, A2C, DQN])
@pytest.mark.parametrize("kind", ["dict", "planes"])
def test_stable_baselines_learns(algorithm, kind):
    policy = "MultiInputPolicy" if kind == "dict" else "MlpPolicy"
    few = {"buffer_size": 100, "learning_starts": 10} if algorithm is DQN else {"n_steps": 16}
    model = algorithm(policy, make(observation=kind), policy_kwargs={"net_arch": [8]}, seed=0, **few)
    model.learn(48)
    action, _ = model.predict(make(observation=kind).reset(seed=0)[0])
    assert 0 <= int(action) < 4


def test_stable_baselines_normalizes_vectors():
    envs = VecNormalize(make_vec_env(make, n_envs=2, vec_env_cls=DummyVecEnv), norm_obs_keys=["probability"])
    PPO("MultiInputPolicy", envs, n_steps=16, policy_kwargs={"net_arch": [8]}, seed=0).learn(48)


@pytest.mark.parametrize("kind", ["dict", "planes"])
@pytest.mark.parametrize("control", ["step", "waypoint"])
def test_maskable_ppo_finds_the_mask_and_keeps_to_it(kind, control):
    def env():
        return gym.make(
            "dragnet/Search-v0",
            scenario=small(budget_cells=40),
            control=control,
            observation=kind,
            masked_action="error",
        )

    envs = make_vec_env(env, n_envs=2)
    assert is_masking_supported(envs)
    assert get_action_masks(envs).shape == (2, env().action_space.n)
    policy = "MultiInputPolicy" if kind == "dict" else "MlpPolicy"
    model = MaskablePPO(policy, envs, n_steps=32, batch_size=32, policy_kwargs={"net_arch": [8]}, seed=0)
    model.learn(128)
    mean, _ = evaluate_policy(model, make_vec_env(env), n_eval_episodes=1)
    assert mean > 0.0, "entropy was removed"
    learned = dragnet.compare(
        small(budget_cells=40),
        {"mine": lambda seen, mask: model.predict(seen, action_masks=mask)[0], "random": "random"},
        seeds=2,
        observation=kind,
        control=control,
    )
    assert [row["policy"] for row in learned] == ["mine", "random"]


@pytest.mark.parametrize("kind", ["dict", "planes"])
def test_a_loop_as_cleanrl_writes_it_learns_from_the_vector_environment(kind):
    """Rollouts into tensors, advantages with the mask of ends, an update with masked logits."""
    envs = gym.make_vec(
        "dragnet/IceCreamCone-v0", num_envs=4, control="step", observation=kind, masked_action="error", copy=True
    )
    rows, columns = envs.unwrapped.scenario.shape

    def tensor(observation):
        if kind == "planes":
            return torch.from_numpy(observation)
        return torch.from_numpy(np.stack([observation["entropy"], observation["distance"]], axis=1))

    channels = 8 if kind == "planes" else 2
    agent = torch.nn.Sequential(
        torch.nn.Conv2d(channels, 4, 3, 2), torch.nn.ReLU(), torch.nn.Flatten(), torch.nn.LazyLinear(5)
    )
    observation, info = envs.reset(seed=1)
    agent(tensor(observation))
    optimizer = torch.optim.Adam(agent.parameters(), 1e-3)
    for _ in range(2):
        kept = []
        for _ in range(16):
            seen, mask = tensor(observation), torch.from_numpy(info["action_mask"]).bool()
            with torch.no_grad():
                logits = agent(seen)[:, :4].masked_fill(~mask, -torch.inf)
                action = torch.distributions.Categorical(logits=logits).sample()
            observation, reward, terminated, truncated, info = envs.step(action.numpy())
            kept.append(
                (seen, mask, action, torch.from_numpy(reward).float(), torch.from_numpy(terminated | truncated))
            )
        seen, mask, action, reward, done = (torch.stack(part) for part in zip(*kept, strict=True))
        output = agent(seen.flatten(0, 1))
        chosen = torch.distributions.Categorical(logits=output[:, :4].masked_fill(~mask.flatten(0, 1), -torch.inf))
        advantage = (reward * ~done).flatten() - output[:, 4]
        loss = advantage.square().mean() - (chosen.log_prob(action.flatten()) * advantage.detach()).mean()
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        assert torch.isfinite(loss)


def test_a_shared_policy_and_a_critic_of_the_team_learn_from_many_teams():
    """Multi-agent PPO as it is usually written: one policy for all robots, a critic of the state, losses of those that act."""
    envs = dragnet.TeamVectorEnv(
        small(budget_cells=12), 4, robots=3, observation="planes", masked_action="error", crashes={3: 22.0}, copy=True
    )
    planes, actions = envs.robot_observation_space["observation"].shape[0], int(envs.robot_action_space.n)

    def network(channels, outputs):
        return torch.nn.Sequential(
            torch.nn.Conv2d(channels, 4, 3, 2), torch.nn.ReLU(), torch.nn.Flatten(), torch.nn.LazyLinear(outputs)
        )

    actor, critic = network(planes, actions), network(envs.single_state_space.shape[0], 1)

    def policy(observation):
        logits = actor(torch.from_numpy(observation["observation"]).flatten(0, 1)).unflatten(0, (4, 3))
        mask = torch.from_numpy(observation["action_mask"]).bool()
        # A robot that stands in a closed cell has no action; none does here.
        return torch.distributions.Categorical(logits=logits.masked_fill(~mask, -torch.inf))

    observation, infos = envs.reset(seed=1)
    policy(observation), critic(torch.from_numpy(envs.state()))
    optimizer = torch.optim.Adam([*actor.parameters(), *critic.parameters()], 1e-3)
    acted, over = 0, 0
    for _ in range(3):
        losses = []
        for _ in range(12):
            state, active = torch.from_numpy(envs.state()), torch.from_numpy(infos["active"])
            chosen = policy(observation)
            action = chosen.sample()
            observation, reward, terminated, truncated, infos = envs.step(action.numpy())
            value, reward = critic(state), torch.from_numpy(reward).float()
            advantage = reward - value
            ratio = (chosen.log_prob(action) - chosen.log_prob(action).detach()).exp()
            losses.append((advantage.square() - ratio * advantage.detach())[active].sum())
            acted += int(active.sum())
            over += int((terminated | truncated).all(axis=1).sum())
        loss = torch.stack(losses).sum()
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        assert torch.isfinite(loss)
    assert over > 4
    assert acted < 3 * 12 * 4 * 3, "some had left"


def test_graphs_are_data_of_pytorch_geometric():
    from torch_geometric.data import Batch, Data
    from torch_geometric.nn import GCNConv

    graphs = []
    for moves in (4, 8):
        env = dragnet.SearchEnv(small(moves=moves), observation="graph")
        observation, _ = env.reset(seed=1)
        mask = observation.pop("action_mask")
        graph = Data(**{name: torch.from_numpy(part) for name, part in observation.items()})
        assert graph.validate()
        # Moves go both ways. Cells that no robot can be in have none.
        assert graph.is_undirected()
        assert graph.num_nodes == len(mask)
        apart = graph.edge_index.unique()
        assert apart.tolist() == np.flatnonzero(env.scenario.traversable).tolist()
        assert set(graph.edge_attr.flatten().tolist()) == ({1.0} if moves == 4 else {1.0, float(np.float32(2**0.5))})
        graphs.append(graph)
    batch = Batch.from_data_list(graphs)
    scores = GCNConv(len(env.features), 1)(batch.x, batch.edge_index)
    assert scores.shape == (2 * len(mask), 1)


def test_teams_are_converted_to_turns_and_back():
    def team():
        return dragnet.parallel_env(small(budget_cells=20), robots=2, observation="planes")

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        api_test(parallel_to_aec(team()), num_cycles=60)
    env, direct = aec_to_parallel(parallel_to_aec(team())), team()
    (seen, _), (expected, _) = env.reset(seed=2), direct.reset(seed=2)
    random = np.random.default_rng(0)
    while direct.agents:
        assert env.agents == direct.agents
        actions = {agent: masked_sample(expected[agent]["action_mask"], random) for agent in direct.agents}
        seen, rewards, *_ = env.step(actions)
        expected, expected_rewards, *_ = direct.step(actions)
        for agent in direct.agents:
            assert np.array_equal(seen[agent]["observation"], expected[agent]["observation"])
            assert rewards[agent] == pytest.approx(expected_rewards[agent])
