"""Features of cells are what the documentation says, in every kind of observation."""

import numpy as np
import pytest
from conftest import masked_sample, small

import dragnet


def walk(env, steps=25):
    """Some steps at random; returns what is observed then."""
    random = np.random.default_rng(0)
    observation, info = env.reset(seed=1)
    for _ in range(steps):
        observation, *_, info = env.step(masked_sample(info["action_mask"], random))
    return observation


@pytest.mark.parametrize("moves", [4, 8])
def test_a_dict_follows_from_the_belief(moves):
    scenario = small(moves=moves)
    env = dragnet.SearchEnv(scenario, control="step")
    seen, belief = walk(env), env.belief()
    rows, columns = scenario.shape
    p = belief["probability"].astype(np.float64)
    with np.errstate(divide="ignore", invalid="ignore"):
        entropy = np.nan_to_num(-p * np.log2(p) - (1 - p) * np.log2(1 - p))
        half = (rows + columns) / 2
        distance = np.where(np.isfinite(belief["distance"]), belief["distance"] / (belief["distance"] + half), 1.0)
    assert np.allclose(seen["probability"], p, atol=1e-6)
    assert np.allclose(seen["entropy"], entropy, atol=1e-5)
    # The sensor's radius is 2 cells, and the variance there 0.005 * 2**2.
    assert np.allclose(seen["observed"], belief["precision"] / (belief["precision"] + 50.0), atol=1e-6)
    assert np.array_equal(seen["traversable"], scenario.traversable)
    assert np.array_equal(seen["searched"], scenario.searched)
    assert np.allclose(seen["distance"], distance, atol=1e-6)
    assert np.allclose(seen["position"], belief["position"] / (rows - 1, columns - 1))
    steps = np.diff(np.stack(np.divmod(env.path, columns)))
    spent = np.hypot(*steps).sum() + (25 - steps.shape[1])
    assert seen["budget"] == pytest.approx(1 - spent / 400, abs=1e-6)
    assert np.array_equal(seen["action_mask"].astype(bool), env.action_masks())
    assert 0 < seen["observed"].max() <= 1


def test_planes_and_graphs_hold_the_same_numbers():
    scenario = small()
    seen = {
        kind: walk(dragnet.SearchEnv(scenario, control="step", observation=kind))
        for kind in ("dict", "planes", "graph")
    }
    env = dragnet.SearchEnv(scenario, control="step", observation="planes")
    walk(env)
    cells = dict(zip(env.features, seen["planes"], strict=True))
    for name in ("probability", "entropy", "observed", "traversable", "searched", "distance"):
        assert np.array_equal(cells[name], seen["dict"][name]), name
    assert np.argwhere(cells["robot"]).tolist() == [env.belief()["position"].tolist()]
    assert (cells["budget"] == seen["dict"]["budget"]).all()
    assert np.array_equal(seen["graph"]["x"][:, :8].T.reshape(8, *scenario.shape), seen["planes"])
    rows, columns = np.divmod(np.arange(14 * 12), 12)
    assert np.allclose(seen["graph"]["x"][:, 8:], np.stack([rows, columns], axis=1) / 14)


def test_from_the_robot_nothing_says_where_it_is():
    """On an open map two robots that have seen the same observe the same, wherever they are, as far as the edges are."""
    scenario = dragnet.Scenario.from_text(
        'name = "open"\nmap = { shape = "all_traversable", rows = 9, columns = 7 }\nsensor.radius = 1\n'
        'objects.cells = [[8, 6]]\nrobots.start = "scattered"\nmission.budget_meters = 900.0\n'
    )
    for kind in ("planes", "graph"):
        env = dragnet.SearchEnv(scenario, observation=kind, frame="robot")
        for seed in range(20):
            observation, _ = env.reset(seed=seed)
            row, column = env.belief()["position"]
            if kind == "planes":
                planes = dict(zip(env.features, observation, strict=True))
                assert planes["robot"][8, 6] == 1
                assert planes["robot"].sum() == 1
                assert planes["traversable"].sum() == 63
                assert planes["traversable"][8 - row :, 6 - column :][:9, :7].all()
                assert planes["distance"][8, 6] == 0
                assert (planes["distance"][planes["traversable"] == 0] == 1).all()
            else:
                place = dict(zip(env.features, observation["x"].T, strict=True))
                assert np.allclose(place["row"].reshape(9, 7)[:, 0], (np.arange(9) - row) / 9)
                assert np.allclose(place["column"].reshape(9, 7)[0], (np.arange(7) - column) / 9)
    env = dragnet.SearchEnv(scenario, frame="robot")
    assert "position" not in env.observation_space.spaces


@pytest.mark.parametrize("kind", ["dict", "planes", "belief"])
def test_teammates_are_where_they_were_last_heard(kind):
    env = dragnet.parallel_env(small(), robots=3, observation=kind)
    observations, _ = env.reset(seed=4)
    random = np.random.default_rng(0)
    for _ in range(10):
        cells = env._native.cells(0)
        for place, agent in enumerate(env.agents):
            planes = observations[agent]
            if kind == "planes":
                planes = dict(zip(env.features, planes["observation"], strict=True))
                assert np.flatnonzero(planes["robot"]).tolist() == [cells[place]]
            others = sorted({cell for other, cell in enumerate(cells) if other != place})
            assert np.flatnonzero(planes["teammates"]).tolist() == others
        moves = {agent: masked_sample(mask, random) for agent, mask in env.action_masks().items()}
        observations, *_ = env.step(moves)


def test_the_state_is_what_the_team_knows_together():
    text = "robots.count = 3\n[[network.partitions]]\nfrom_seconds = 0.0\nto_seconds = 1e6\ngroups = [[1], [2]]"
    env = dragnet.parallel_env(small(text), crashes={3: 42.0})
    env.reset(seed=4)
    random = np.random.default_rng(0)
    for _ in range(12):
        env.step({agent: masked_sample(mask, random) for agent, mask in env.action_masks().items()})
    state = env.state()
    assert state in env.state_space
    seen = [env.belief(agent)["precision"] > 0 for agent in env.possible_agents]
    assert np.array_equal(state[2] > 0, np.any(seen, axis=0))
    assert np.array_equal(state[3:5], [env.scenario.traversable, env.scenario.searched])
    assert not all(np.array_equal(part, seen[0]) for part in seen)
    robots = [np.flatnonzero(plane).tolist() for plane in state[5:]]
    assert robots == [[cell] for cell in env._native.cells(0)[:2]] + [[]], "the third has crashed"
