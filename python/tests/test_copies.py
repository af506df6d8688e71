"""A clone, a deep copy and a pickle have the future of their original."""

import copy
import pickle

import numpy as np
import pytest
from conftest import KINDS, masked_sample, small
from gymnasium.utils.env_checker import data_equivalence

import dragnet

COPIES = {
    "clone": lambda env: env.clone(),
    "deepcopy": copy.deepcopy,
    "pickle": lambda env: pickle.loads(pickle.dumps(env)),
}


def future(env, steps=40):
    """What steps bring that the environment's own action space draws, over the ends of episodes."""
    brought, info = [], env.reset()[1] if env.termination_reason else env._info()
    for _ in range(steps):
        observation, *judged, info = env.step(env.action_space.sample(mask=info["action_mask"]))
        brought.append((observation, *judged, info))
        if judged[1] or judged[2]:
            observation, info = env.reset()
            brought.append((observation, info))
    return brought, env.digest


@pytest.mark.parametrize("how", COPIES)
@pytest.mark.parametrize("control", ["waypoint", "step"])
@pytest.mark.parametrize("kind", KINDS)
def test_a_copy_has_the_same_future(how, control, kind):
    env = dragnet.SearchEnv(small(budget_cells=30), control=control, observation=kind, render_mode="rgb_array")
    env.action_space.seed(5)
    env.reset(seed=1)
    # Steps that stay, and a second episode.
    for turn in range(12):
        *_, terminated, truncated, info = env.step(turn % 4)
        if terminated or truncated:
            env.reset()
    twin = COPIES[how](env)
    assert type(twin) is dragnet.SearchEnv
    assert twin.path.tolist() == env.path.tolist()
    assert np.array_equal(twin.render(), env.render())
    before = env.digest
    imagined, last = future(twin)
    assert env.digest == before, "the original has not moved"
    happened, digest = future(env)
    assert digest == last
    assert data_equivalence(imagined, happened, exact=True)
    assert len(imagined) > 40, "an episode ended"


@pytest.mark.parametrize("how", COPIES)
def test_a_copy_before_the_first_reset(how):
    env = COPIES[how](dragnet.SearchEnv(small()))
    with pytest.raises(RuntimeError, match="before the first reset"):
        env.step(0)
    assert env.reset(seed=3)[1]["seed"] == 3


@pytest.mark.parametrize("how", COPIES)
def test_a_copy_of_a_vector_environment_has_the_same_future(how):
    envs = dragnet.SearchVectorEnv(small(budget_cells=20), 3, control="step")
    envs.reset(seed=1)
    random = np.random.default_rng(0)
    for _ in range(30):
        envs.step(random.integers(0, 4, 3))
    twin = COPIES[how](envs)
    for _ in range(50):
        actions = random.integers(0, 4, 3)
        mine, *judged, info = envs.step(actions)
        its, *its_judged, its_info = twin.step(actions)
        assert data_equivalence(mine, its, exact=True)
        assert data_equivalence(judged, its_judged, exact=True)
        assert np.array_equal(info["seed"], its_info["seed"])
        assert not np.shares_memory(mine["probability"], its["probability"])


@pytest.mark.parametrize("how", COPIES)
@pytest.mark.parametrize("control", ["waypoint", "step"])
def test_a_copy_of_a_team_has_the_same_future(how, control):
    scenario = small("network = { loss = 0.3, delay_seconds = 7.0 }", budget_cells=30)
    team = dragnet.parallel_env(scenario, robots=3, control=control, crashes={2: 42.0})
    random = np.random.default_rng(0)
    team.reset(seed=1)

    def moves():
        return {agent: masked_sample(mask, random) for agent, mask in team.action_masks().items()}

    for _ in range(6):
        team.step(moves())
    twin = COPIES[how](team)
    assert twin.digests == team.digests
    crashed = False
    while team.agents:
        assert twin.agents == team.agents
        actions = moves()
        brought = team.step(actions)
        assert data_equivalence(brought, twin.step(actions), exact=True)
        assert np.array_equal(team.state(), twin.state())
        assert twin.digests == team.digests
        crashed |= "robot_2" not in team.agents
    assert crashed
    assert team.reset()[1]["robot_1"]["seed"] == twin.reset()[1]["robot_1"]["seed"]


@pytest.mark.parametrize("how", COPIES)
@pytest.mark.parametrize("kind", ["dict", "planes"])
def test_a_copy_of_many_teams_has_the_same_future(how, kind):
    scenario = small("network = { loss = 0.3, delay_seconds = 7.0 }", budget_cells=20)
    choices = {"robots": 3, "observation": kind, "frame": "robot", "crashes": {2: 42.0}, "render_mode": "rgb_array"}
    envs = dragnet.TeamVectorEnv(scenario, 3, **choices)
    with pytest.raises(RuntimeError, match="before the first reset"):
        COPIES[how](envs).step(np.zeros((3, 3), dtype=int))
    random = np.random.default_rng(0)
    envs.reset(seed=1)
    # Some have begun anew, and one just ends.
    for _ in range(30):
        envs.step(random.integers(0, 4, (3, 3)))
    envs.reset(seed=[None, 4, None], options={"reset_mask": np.array([False, True, False])})
    while not envs._arrays["over"].any():
        envs.step(random.integers(0, 4, (3, 3)))
    twin = COPIES[how](envs)
    assert type(twin) is dragnet.TeamVectorEnv
    assert data_equivalence(twin.render(), envs.render(), exact=True)
    assert data_equivalence(twin.belief(), envs.belief(), exact=True)
    for _ in range(50):
        assert np.array_equal(envs.state(), twin.state())
        actions = random.integers(0, 4, (3, 3))
        mine, its = envs.step(actions), twin.step(actions)
        assert data_equivalence(mine, its, exact=True)
        assert not np.shares_memory(mine[0]["action_mask"], its[0]["action_mask"])


def test_a_clone_searches_a_tree():
    """Looking one step ahead with clones chooses what then happens."""
    env = dragnet.SearchEnv(small(), control="step", reward="entropy")
    _, info = env.reset(seed=2)
    for _ in range(10):
        outcomes = {action: env.clone().step(action)[1] for action in np.flatnonzero(info["action_mask"])}
        best = max(outcomes, key=outcomes.get)
        _, reward, *_, info = env.step(best)
        assert reward == outcomes[best] == max(outcomes.values())
