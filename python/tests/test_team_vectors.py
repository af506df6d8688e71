"""Many teams in one batch: the very episodes of single ones, bit for bit."""

import numpy as np
import pytest
from conftest import KINDS, masked_sample, small
from gymnasium.utils.env_checker import data_equivalence
from gymnasium.vector import AutoresetMode, VectorEnv

import dragnet

ROBOTS = 3
FAULTS = "network = { loss = 0.3, delay_seconds = 7.0, jitter_seconds = 4.0, duplication = 0.2 }"
OF_TEAMS = ("seed", "f1", "recall", "time_seconds")
OF_ROBOTS = ("action_mask", "termination_reason", "path_cells")


class Singles:
    """Teams stepped one by one, begun anew with the step after their end."""

    def __init__(self, scenario, count, **choices):
        self.envs = [dragnet.parallel_env(scenario, robots=ROBOTS, **choices) for _ in range(count)]
        self.told = [None] * count

    def reset(self, seeds, mask=None):
        for place, env in enumerate(self.envs):
            if mask is None or mask[place]:
                self.begin(place, env, seeds[place])

    def begin(self, place, env, seed=None):
        observations, infos = env.reset(seed=seed)
        nothing, no = dict.fromkeys(env.agents, 0.0), dict.fromkeys(env.agents, False)
        self.told[place] = (observations, nothing, no, no, infos)

    def step(self, actions):
        for place, env in enumerate(self.envs):
            if env.agents:
                named = dict(zip(env.possible_agents, actions[place].tolist(), strict=True))
                self.told[place] = env.step({agent: named[agent] for agent in env.agents})
            else:
                self.begin(place, env)


def check_equal(batch, singles, observations, rewards, terminated, truncated, infos):
    """What the batch tells is what each team alone tells, of its robots that had not left before."""
    for place, (env, told) in enumerate(zip(singles.envs, singles.told, strict=True)):
        for robot, agent in enumerate(batch.possible_agents):
            if agent not in told[0]:
                assert rewards[place, robot] == 0
                assert terminated[place, robot] or truncated[place, robot]
                continue
            seen = {name: part[place, robot] for name, part in observations.items()}
            assert data_equivalence(seen, told[0][agent], exact=True), (place, agent)
            assert rewards[place, robot] == told[1][agent]
            assert (terminated[place, robot], truncated[place, robot]) == (told[2][agent], told[3][agent])
            for name in OF_TEAMS:
                assert infos[name][place] == told[4][agent][name], name
            for name in OF_ROBOTS:
                assert np.array_equal(infos[name][place, robot], told[4][agent][name]), name
            assert infos["active"][place, robot] == (agent in env.agents)


def sampled(masks, random):
    return np.array([[masked_sample(mask, random) for mask in team] for team in masks])


@pytest.mark.parametrize("control", ["step", "waypoint"])
@pytest.mark.parametrize("frame", ["map", "robot"])
@pytest.mark.parametrize("kind", KINDS)
def test_every_team_goes_through_the_episodes_of_a_single_one(kind, frame, control):
    choices = {"control": control, "observation": kind, "frame": frame, "crashes": {2: 82.0}}
    scenario = small(FAULTS, budget_cells=30)
    batch = dragnet.TeamVectorEnv(scenario, 4, robots=ROBOTS, **choices)
    singles = Singles(scenario, 4, **choices)
    observations, infos = batch.reset(seed=3)
    singles.reset([3, 4, 5, 6])
    never = np.zeros((4, ROBOTS), dtype=bool)
    rewards, terminated, truncated = np.zeros((4, ROBOTS)), never, never
    random = np.random.default_rng(0)
    ends, reasons = np.zeros(4, dtype=int), set()
    for _ in range(100):
        check_equal(batch, singles, observations, rewards, terminated, truncated, infos)
        for place, env in enumerate(singles.envs):
            assert np.array_equal(batch.state()[place], env.state())
            assert batch._native.digests(place) == env._native.digests(0)
        assert observations in batch.observation_space
        assert batch.state() in batch.state_space
        actions = sampled(infos["action_mask"], random)
        observations, rewards, terminated, truncated, infos = batch.step(actions)
        singles.step(actions)
        ends += (terminated | truncated).all(axis=1)
        reasons |= set(infos["termination_reason"].flat)
    assert ends.min() >= 2, ends
    assert {"crashed", "spent", "searching"} <= reasons


@pytest.mark.parametrize("reward", ["entropy", "found", "f1"])
@pytest.mark.parametrize("moves", [4, 8])
def test_actions_that_cannot_be_taken_cost_the_same(reward, moves):
    scenario = small(moves=moves, budget_cells=25)
    batch = dragnet.TeamVectorEnv(scenario, 3, robots=ROBOTS, reward=reward)
    singles = Singles(scenario, 3, reward=reward)
    batch.reset(seed=8)
    singles.reset([8, 9, 10])
    random = np.random.default_rng(1)
    total = 0.0
    for _ in range(60):
        actions = random.integers(0, moves, (3, ROBOTS))
        told = batch.step(actions)
        singles.step(actions)
        check_equal(batch, singles, *told)
        total += abs(told[1]).sum()
    assert total > 0


def test_some_teams_begin_anew():
    scenario = small(budget_cells=20)
    batch = dragnet.TeamVectorEnv(scenario, 4, robots=ROBOTS, copy=True)
    singles = Singles(scenario, 4)
    _, infos = batch.reset(seed=3)
    singles.reset([3, 4, 5, 6])
    random = np.random.default_rng(0)
    met_an_end = False
    for turn in range(50):
        actions = sampled(infos["action_mask"], random)
        told = batch.step(actions)
        singles.step(actions)
        check_equal(batch, singles, *told)
        infos = told[-1]
        if turn % 3 == 2:
            mask = random.random(4) < 0.5
            mask[turn % 4] = True
            met_an_end |= bool((told[2] | told[3]).all(axis=1)[mask].any())
            seeds = [None] * 4 if turn % 2 else [9, None, 7, None]
            observations, infos = batch.reset(seed=seeds, options={"reset_mask": mask})
            singles.reset(seeds, mask)
            assert np.array_equal(infos["_seed"], mask)
            assert infos["active"][mask].all()
            for place in np.flatnonzero(mask):
                expected = singles.told[place][0]
                for robot, agent in enumerate(batch.possible_agents):
                    seen = {name: part[place, robot] for name, part in observations.items()}
                    assert data_equivalence(seen, expected[agent], exact=True)
    assert met_an_end


def test_a_search_that_is_over_as_it_begins_says_so_after_its_first_action():
    scenario = small("mission.budget_seconds = 1e6").with_density(1e-9)
    single = dragnet.parallel_env(scenario, robots=2)
    observations, _ = single.reset(seed=1)
    assert set(observations) == set(single.agents) == {"robot_1", "robot_2"}
    _, rewards, terminated, _, infos = single.step({"robot_1": 0, "robot_2": 0})
    assert list(terminated.values()) == [True, True]
    assert list(rewards.values()) == [0, 0]
    assert infos["robot_1"]["termination_reason"] == "found"
    assert infos["robot_1"]["time_seconds"] == 0
    with pytest.raises(RuntimeError, match="call reset"):
        single.step({})
    batch = dragnet.TeamVectorEnv(scenario, 3, robots=2)
    for turn in range(4):
        _, infos = batch.reset(seed=1) if turn == 0 else batch.step(np.zeros((3, 2), dtype=int))[::4]
        assert infos["active"].all() == (turn % 2 == 0)


def test_a_robot_that_has_left_is_told_of_and_not_asked():
    batch = dragnet.TeamVectorEnv(small(), 2, robots=2, crashes={1: 12.0}, masked_action="error")
    _, infos = batch.reset(seed=0)
    while infos["active"].all():
        _, rewards, terminated, truncated, infos = batch.step(infos["action_mask"].argmax(axis=2))
    assert terminated.tolist() == [[True, False]] * 2
    assert infos["termination_reason"].tolist() == [["crashed", "searching"]] * 2
    assert rewards.any(axis=1).all(), "the team's last reward is also that of the robot that has crashed"
    actions = infos["action_mask"].argmax(axis=2)
    actions[:, 0] = 10**6
    _, rewards, terminated, _, infos = batch.step(actions)
    assert terminated.tolist() == [[True, False]] * 2
    assert not rewards[:, 0].any()
    assert not batch.state()[:, 5].any()


def test_it_is_a_vector_environment_with_spaces_for_teams_and_robots():
    batch = dragnet.TeamVectorEnv(small(), 5, robots=ROBOTS, observation="planes", render_mode="rgb_array")
    assert isinstance(batch, VectorEnv)
    assert batch.metadata["autoreset_mode"] == AutoresetMode.NEXT_STEP
    assert batch.possible_agents == ["robot_1", "robot_2", "robot_3"]
    single = dragnet.parallel_env(small(), robots=ROBOTS, observation="planes")
    assert batch.robot_observation_space == single.observation_space("robot_1")
    assert batch.robot_action_space == single.action_space("robot_1")
    assert batch.single_state_space == single.state_space
    assert batch.single_action_space.shape == (ROBOTS,)
    assert batch.action_space.shape == (5, ROBOTS)
    assert batch.features == single.features
    observations, infos = batch.reset(seed=1)
    assert observations["observation"].shape == (5, ROBOTS, 9, 14, 12)
    assert observations["observation"].dtype == np.float32
    assert infos["action_mask"].shape == (5, ROBOTS, 4)
    assert np.array_equal(infos["action_mask"].astype(bool), batch.action_masks())
    _, rewards, terminated, truncated, _ = batch.step(batch.action_space.sample())
    assert rewards.shape == terminated.shape == truncated.shape == (5, ROBOTS)
    assert (rewards.dtype, terminated.dtype, truncated.dtype) == (np.float64, bool, bool)
    assert batch.belief()["log_odds"].shape == (5, ROBOTS, 14, 12)
    pictures = batch.render()
    single = dragnet.parallel_env(small(), robots=ROBOTS, render_mode="rgb_array")
    single.reset(seed=1)
    assert len(pictures) == 5
    assert pictures[0].shape == single.render().shape


def test_arrays_stay_where_they_are_unless_copied():
    for copy in (False, True):
        batch = dragnet.TeamVectorEnv(small(), 2, robots=2, copy=copy)
        first, _ = batch.reset(seed=0)
        state = batch.state()
        second, *_ = batch.step(np.zeros((2, 2), dtype=np.int64))
        for name in ("probability", "teammates", "position", "action_mask"):
            assert np.shares_memory(first[name], second[name]) != copy, name
        assert np.shares_memory(state, batch.state()) != copy


def test_a_seed_for_each_environment_is_that_episode_and_others_follow_from_it():
    batch = dragnet.TeamVectorEnv(small(budget_cells=6), 3, robots=2)
    runs = []
    for _ in range(2):
        _, infos = batch.reset(seed=[5, 2**64 - 1, 7])
        seeds = [infos["seed"].tolist()]
        for _ in range(30):
            *_, infos = batch.step(np.zeros((3, 2), dtype=np.int64))
            seeds.append(infos["seed"].tolist())
        runs.append(seeds)
    assert runs[0] == runs[1]
    assert runs[0][0] == [5, 2**64 - 1, 7]
    assert len({seed for row in runs[0] for seed in row}) > 6
    batch.reset()
    assert batch.reset()[1]["seed"].tolist() != runs[0][0]
