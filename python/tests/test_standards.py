"""What Gymnasium and PettingZoo ask of environments, by their own checks."""

import pickle
import subprocess
import sys

import gymnasium as gym
import numpy as np
import pytest
from conftest import KINDS, ROOT, masked_sample, small
from gymnasium.utils.env_checker import check_env, data_equivalence
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from pettingzoo.test import parallel_api_test, parallel_seed_test

import dragnet

CONTROLS = ["waypoint", "step"]


@pytest.mark.parametrize("control", CONTROLS)
@pytest.mark.parametrize("moves", [4, 8])
@pytest.mark.parametrize("reward", ["entropy", "found", "f1"])
@pytest.mark.parametrize("frame", ["map", "robot"])
@pytest.mark.parametrize("kind", ["dict", "planes", "graph"])
@pytest.mark.filterwarnings("error")
def test_gymnasium_accepts_the_environment_without_a_warning(control, moves, reward, frame, kind):
    arguments = {"control": control, "reward": reward, "observation": kind, "frame": frame}
    env = gym.make("dragnet/Search-v0", scenario=small(moves=moves), render_mode="rgb_array", **arguments)
    check_env(env.unwrapped)


@pytest.mark.filterwarnings("error")
def test_gymnasium_accepts_the_default_without_a_warning():
    check_env(gym.make("dragnet/Search-v0").unwrapped)


def test_every_registered_environment_is_made_with_its_scenario_alone_and_batched():
    names = [spec.name for spec in gym.registry.values() if spec.namespace == "dragnet"]
    assert {"Search", "IceCreamCone", "OpenMap", "OpenAsterisk", "FigureFour", "Jersey", "MissingPerson"} == set(names)
    for name in names:
        env = gym.make(f"dragnet/{name}-v0")
        observation, _ = env.reset(seed=1)
        assert observation in env.observation_space, name
        assert env.unwrapped.scenario.robots == 1
        # With its map, which comes with the package too.
        assert pickle.loads(pickle.dumps(env.unwrapped)).digest == env.unwrapped.digest
    envs = gym.make_vec("dragnet/OpenMap-v0", num_envs=2, observation="planes")
    planes, _ = envs.reset(seed=1)
    assert planes.shape == (2, 8, 30, 30)
    for mode in ("sync", "async"):
        theirs = gym.make_vec("dragnet/OpenMap-v0", num_envs=2, vectorization_mode=mode, observation="planes")
        assert np.array_equal(theirs.reset(seed=1)[0], planes)
        theirs.close()


def test_the_scenarios_that_come_with_the_package_are_there_without_a_checkout(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    scenarios = dragnet.scenarios()
    assert {"ice_cream_cone", "warehouse", "paper/figure_four"} <= set(scenarios)
    for name, summary in scenarios.items():
        assert summary.endswith((".", "?")), name
        assert dragnet.Scenario.load(name).shape[0] > 1
    # A registered environment is that of the package, whatever is in the folder.
    (tmp_path / "ice_cream_cone").write_text("nothing")
    assert gym.make("dragnet/IceCreamCone-v0").unwrapped.scenario.shape == (30, 30)


def test_the_version_is_that_of_the_package():
    assert f'\nversion = "{dragnet.__version__}"\n' in (ROOT / "Cargo.toml").read_text()


@pytest.mark.parametrize("control", CONTROLS)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.filterwarnings("ignore:option 'options' has no effect")
def test_pettingzoo_accepts_the_team(control, kind):
    scenario = small("network = { loss = 0.2, delay_seconds = 3.0 }", budget_cells=60)

    def team():
        return dragnet.parallel_env(
            scenario, robots=3, control=control, observation=kind, crashes={2: 150.0}, render_mode="rgb_array"
        )

    parallel_api_test(team(), num_cycles=500)
    parallel_seed_test(team, num_cycles=100)


@pytest.mark.parametrize("control", CONTROLS)
@pytest.mark.parametrize("frame", ["map", "robot"])
@pytest.mark.parametrize("kind", KINDS)
def test_the_vector_environment_goes_through_the_episodes_of_single_ones(control, frame, kind):
    """Two or more episodes of each lane, bit for bit, against Gymnasium's own vector environment of ours."""
    scenario = small(budget_cells=40)
    choices = {"control": control, "frame": frame, "observation": kind}
    ours = gym.make_vec("dragnet/Search-v0", num_envs=5, scenario=scenario, **choices)
    assert isinstance(ours, dragnet.SearchVectorEnv)
    assert ours.metadata["autoreset_mode"] == AutoresetMode.NEXT_STEP
    theirs = SyncVectorEnv([lambda: dragnet.SearchEnv(scenario, **choices)] * 5)
    assert ours.observation_space == theirs.observation_space
    assert ours.action_space == theirs.action_space
    (seen, info), (expected, expected_info) = ours.reset(seed=3), theirs.reset(seed=3)
    random = np.random.default_rng(0)
    ends = np.zeros(5, dtype=int)
    for _ in range(150):
        assert data_equivalence(seen, expected, exact=True)
        assert seen in ours.observation_space
        for name in ("action_mask", "seed", "f1", "recall", "path_cells", "time_seconds"):
            assert np.array_equal(info[name], expected_info[name]), name
        actions = np.array([masked_sample(mask, random) for mask in info["action_mask"]])
        seen, *judged, info = ours.step(actions)
        expected, *expected_judged, expected_info = theirs.step(actions)
        for mine, its in zip(judged, expected_judged, strict=True):
            assert np.array_equal(mine, its)
        ends += judged[1] | judged[2]
    assert ends.min() >= 2, ends


def test_some_environments_begin_anew_as_in_gymnasiums_own_vector_environment():
    scenario = small(budget_cells=40)
    ours = dragnet.SearchVectorEnv(scenario, 4, copy=True)
    theirs = SyncVectorEnv([lambda: dragnet.SearchEnv(scenario)] * 4)
    random = np.random.default_rng(0)
    (seen, info), (expected, _) = ours.reset(seed=3), theirs.reset(seed=3)
    met_an_end = False
    for turn in range(60):
        actions = np.array([masked_sample(mask, random) for mask in info["action_mask"]])
        seen, _, *ended, info = ours.step(actions)
        expected, _, *its_ended, _ = theirs.step(actions)
        assert data_equivalence(seen, expected, exact=True)
        assert np.array_equal(ended, its_ended)
        if turn % 3 == 2:
            mask = random.random(4) < 0.5
            mask[turn % 4] = True
            is_over = ended[0] | ended[1]
            met_an_end |= bool(is_over.any())
            seed = None if turn % 2 else [9, None, 7, None]
            seen, told = ours.reset(seed=seed, options={"reset_mask": mask})
            expected, its_told = theirs.reset(seed=seed, options={"reset_mask": mask.copy()})
            assert data_equivalence(seen, expected, exact=True)
            assert np.array_equal(told["_seed"], mask)
            assert np.array_equal(told["seed"][mask], its_told["seed"][mask])
            info = told
    assert met_an_end


def test_environments_and_comparisons_work_in_a_process_that_was_forked():
    script = """
import os, signal, warnings
import numpy as np
import dragnet
warnings.simplefilter("ignore")
text = '''
name = "small"
map = { shape = "all_traversable", rows = 8, columns = 8 }
objects.count = 2
mission.budget_meters = 200.0
'''
def episode():
    env = dragnet.SearchVectorEnv(dragnet.Scenario.from_text(text), num_envs=16, masked_action="stay")
    env.reset(seed=0)
    teams = dragnet.TeamVectorEnv(dragnet.Scenario.from_text(text), num_envs=16, robots=2)
    teams.reset(seed=0)
    table = dragnet.compare([dragnet.Scenario.from_text(text)], ["random"], seeds=4)
    rewards = env.step(np.arange(16))[1], teams.step(np.zeros((16, 2), dtype=int))[1]
    return *(reward.tobytes() for reward in rewards), table[0]["auc_f1_mean"]
expected = episode()
pid = os.fork()
if pid == 0:
    signal.alarm(60)  # It would wait for ever for the threads that its parent had.
    os._exit(0 if episode() == expected else 1)
assert os.waitpid(pid, 0)[1] == 0
assert episode() == expected
"""
    subprocess.run([sys.executable, "-c", script], check=True, timeout=120)


def test_the_arrays_of_a_vector_environment_stay_where_they_are_unless_copied():
    for copy in (False, True):
        env = dragnet.SearchVectorEnv(small(), 2, control="step", copy=copy)
        first, info = env.reset(seed=0)
        second, *_ = env.step([int(np.argmax(mask)) for mask in info["action_mask"]])
        for name in ("probability", "distance", "position", "action_mask"):
            assert np.shares_memory(first[name], second[name]) != copy, name


def test_a_seed_is_an_episode_and_the_next_ones_follow_from_it():
    env = dragnet.SearchEnv(small())
    runs = []
    for _ in range(2):
        first, info = env.reset(seed=11)
        assert info["seed"] == 11
        second, following = env.reset()
        runs.append((first, info, second, following))
    assert data_equivalence(runs[0], runs[1], exact=True)
    assert runs[0][3]["seed"] != 11


def test_a_scenario_is_pickled_with_all_that_was_changed():
    scenario = small().with_robots(3).with_density(0.1).with_budget_cells(33)
    again = pickle.loads(pickle.dumps(scenario))
    assert (again.robots, again.shape) == (3, scenario.shape)
    table = dragnet.compare([scenario, again], ["random"], seeds=2)
    assert {**table[0], "decision_ms_p50": 0, "decision_ms_p99": 0} == {
        **table[1],
        "decision_ms_p50": 0,
        "decision_ms_p99": 0,
    }
