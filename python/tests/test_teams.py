"""A team of robots, each with a belief of its own."""

import numpy as np
import pytest
from conftest import masked_sample, small
from gymnasium.utils.env_checker import data_equivalence

import dragnet


def play(env, seed=0, steps=10_000):
    """Random moves; yields what each step brought."""
    random = np.random.default_rng(seed)
    observations, infos = env.reset(seed=seed)
    for _ in range(steps):
        if not env.agents:
            return
        moves = {agent: masked_sample(observations[agent]["action_mask"], random) for agent in env.agents}
        observations, rewards, terminated, truncated, infos = env.step(moves)
        yield observations, rewards, terminated, truncated, infos


def test_a_robot_that_dies_leaves_once_and_the_others_search_on():
    env = dragnet.parallel_env(small(), robots=3, crashes={2: 42.0})
    left = {}
    for step, (observations, rewards, terminated, truncated, infos) in enumerate(play(env)):
        keys = set(observations)
        assert keys == set(rewards) == set(terminated) == set(truncated) == set(infos)
        assert not keys & set(left), "nobody comes back"
        for agent in keys:
            is_out = terminated[agent] or truncated[agent]
            assert is_out == (agent not in env.agents)
            if is_out:
                left[agent] = (step, infos[agent]["termination_reason"], terminated[agent])
    # Five seconds a cell: it was on its way to its ninth.
    assert left["robot_2"] == (8, "crashed", True)
    assert set(left) == {"robot_1", "robot_2", "robot_3"}
    assert left["robot_1"][0] > 8


def test_budgets_end_a_search_as_truncation():
    env = dragnet.parallel_env(small(budget_cells=12), robots=2)
    *_, (_, _, terminated, truncated, infos) = play(env)
    assert truncated == {"robot_1": True, "robot_2": True}
    assert not any(terminated.values())
    assert infos["robot_1"]["path_cells"] == 12


def test_beliefs_are_shared_as_the_network_allows():
    def differing(network):
        env = dragnet.parallel_env(small(network, budget_cells=60), robots=3)
        count = 0
        for _ in play(env):
            digests = env.digests
            count += digests["robot_1"] != digests["robot_2"]
        return count

    assert differing("") == 0
    assert differing("network = { loss = 0.3, delay_seconds = 7.0 }") > 10
    text = "robots.count = 3\n[[network.partitions]]\nfrom_seconds = 0.0\nto_seconds = 1e6\ngroups = [[1], [2]]"
    env = dragnet.parallel_env(small(text, budget_cells=20))
    for observations, *_ in play(env):
        # The third is on neither side of the partition's groups: nobody hears of anybody.
        assert not observations["robot_1"]["teammates"].any()
    assert len(set(env.digests.values())) == 4


@pytest.mark.parametrize("control", ["step", "waypoint"])
def test_one_robot_of_a_team_is_the_robot_of_the_single_environment(control):
    scenario = small(budget_cells=50)
    alone = dragnet.SearchEnv(scenario, control="step")
    decide = dragnet.Policy("greedy", scenario)
    team = dragnet.parallel_env(scenario, robots=1, control=control)
    observations, _ = team.reset(seed=6)
    expected, _ = alone.reset(seed=6)
    while team.agents:
        assert not observations["robot_1"].pop("teammates").any()
        for name, part in expected.items():
            if name != "action_mask" or control == "step":
                assert np.array_equal(observations["robot_1"][name], part), name
        assert data_equivalence(team.belief("robot_1"), alone.belief(), exact=True)
        decision = decide(alone.belief())
        action = decision.step if control == "step" else decision.waypoint
        observations, rewards, terminated, truncated, _ = team.step({"robot_1": action})
        expected, reward, *ends, _ = alone.step(decision.step)
        assert rewards["robot_1"] == pytest.approx(reward, abs=1e-9)
        assert ends == [terminated["robot_1"], truncated["robot_1"]]
