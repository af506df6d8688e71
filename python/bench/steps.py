"""Steps a second: 64 environments of 30 x 30 cells, ``control="step"``, against the same world in NumPy; and robot steps a
second of 64 teams of three robots, with their network.

Usage: python steps.py [SECONDS]

The package has to be built with ``maturin develop --release``. Everything is measured in turn, several times over; medians
are printed, and lowest and highest; on a machine that others use, what the quickest calls take tells more. That both worlds
are the same is checked first: after the same moves they have the same precision in every cell and the same distances.
"""

import statistics
import sys
import time

import numpy as np
from numpy_search import NumpySearch

import dragnet

SIDE = 30
LANES = 64
ROBOTS = 3
ROUNDS = 5
SCENARIO = f"""
name = "steps"
map = {{ shape = "all_traversable", rows = {SIDE}, columns = {SIDE}, cell_meters = 30.0 }}
objects.density = 0.01
robots.start = "scattered"
mission.budget_meters = 9000.0
"""


def shortest_paths():
    rows, columns = np.divmod(np.arange(SIDE * SIDE), SIDE)
    apart = np.abs(rows[:, None] - rows) + np.abs(columns[:, None] - columns)
    return apart.astype(np.float32).reshape(-1, SIDE, SIDE)


def theirs(distances=None):
    return NumpySearch(SIDE, SIDE, 5, 0.005, 0.01, 300, distances)


def check_same_world():
    ours, other = dragnet.SearchEnv(dragnet.Scenario.from_text(SCENARIO), control="step"), theirs()
    _, info = ours.reset(seed=1)
    other.reset(seed=1)
    other.position = ours.belief()["position"]
    other.precision[:] = 0
    seen, *_ = other._look()
    random = np.random.default_rng(0)
    for _ in range(30):
        assert np.allclose(seen["precision"], ours.belief()["precision"], rtol=1e-4)
        assert np.array_equal(seen["distance"], ours.belief()["distance"])
        action = random.choice(np.flatnonzero(info["action_mask"]))
        _, _, over, _, info = ours.step(action)
        seen, *_ = other.step(action)
        if over:
            break


def vector(seconds, observation="dict"):
    env = batched(observation)
    random = np.random.default_rng(0)
    _, info = env.reset(seed=0)
    keys = random.random((64, LANES, 4))
    steps, start = 0, time.perf_counter()
    while time.perf_counter() - start < seconds:
        actions = (info["action_mask"] * keys[steps % 64]).argmax(axis=1)
        _, _, _, _, info = env.step(actions)
        steps += 1
    return steps * LANES / (time.perf_counter() - start)


def planes(seconds):
    return vector(seconds, "planes")


def graph(seconds):
    return vector(seconds, "graph")


def batched(observation):
    scenario = dragnet.Scenario.from_text(SCENARIO)
    return dragnet.SearchVectorEnv(scenario, LANES, control="step", observation=observation)


def single(seconds):
    env = dragnet.SearchEnv(dragnet.Scenario.from_text(SCENARIO), control="step")
    random = np.random.default_rng(0)
    _, info = env.reset(seed=0)
    keys = random.random((64, 4))
    steps, start = 0, time.perf_counter()
    while time.perf_counter() - start < seconds:
        action = (info["action_mask"] * keys[steps % 64]).argmax()
        _, _, terminated, truncated, info = env.step(action)
        if terminated or truncated:
            _, info = env.reset()
        steps += 1
    return steps / (time.perf_counter() - start)


def teams(seconds, observation="dict", *, with_state=False):
    env = batched_teams(observation)
    random = np.random.default_rng(0)
    _, info = env.reset(seed=0)
    keys = random.random((64, LANES, ROBOTS, 4))
    steps, acted, start = 0, 0, time.perf_counter()
    while time.perf_counter() - start < seconds:
        acted += int(info["active"].sum())
        actions = (info["action_mask"] * keys[steps % 64]).argmax(axis=2)
        _, _, _, _, info = env.step(actions)
        if with_state:
            env.state()
        steps += 1
    # Of the robots that search; where an episode begins anew nobody moves.
    return acted / (time.perf_counter() - start)


def team_planes(seconds):
    return teams(seconds, "planes")


def team_graph(seconds):
    return teams(seconds, "graph")


def team_state(seconds):
    """Planes, and the state for a critic in each step."""
    return teams(seconds, "planes", with_state=True)


def batched_teams(observation):
    return dragnet.TeamVectorEnv(dragnet.Scenario.from_text(SCENARIO), LANES, robots=ROBOTS, observation=observation)


def one_team(seconds):
    """Robot steps of one team with PettingZoo's interface."""
    env = dragnet.parallel_env(dragnet.Scenario.from_text(SCENARIO), robots=ROBOTS)
    random = np.random.default_rng(0)
    _, infos = env.reset(seed=0)
    keys = random.random((64, ROBOTS, 4))
    steps, acted, start = 0, 0, time.perf_counter()
    while time.perf_counter() - start < seconds:
        if not env.agents:
            _, infos = env.reset()
        key = dict(zip(env.possible_agents, keys[steps % 64], strict=True))
        actions = {agent: int((infos[agent]["action_mask"] * key[agent]).argmax()) for agent in env.agents}
        *_, infos = env.step(actions)
        acted += len(actions)
        steps += 1
    return acted / (time.perf_counter() - start)


def numpy_kept(seconds):
    return numpy_world(seconds, DISTANCES)


def numpy_world(seconds, distances=None):
    envs = [theirs(distances) for _ in range(LANES)]
    masks = [env.reset(lane)[4] for lane, env in enumerate(envs)]
    random = np.random.default_rng(0)
    keys = random.random((64, LANES, 4))
    steps, start = 0, time.perf_counter()
    while time.perf_counter() - start < seconds:
        for lane, env in enumerate(envs):
            action = (masks[lane] * keys[steps % 64, lane]).argmax()
            _, _, found, spent, masks[lane], _ = env.step(action)
            if found or spent:
                masks[lane] = env.reset(steps)[4]
        steps += 1
    return steps * LANES / (time.perf_counter() - start)


def main(seconds=2.0):
    check_same_world()
    measured = {
        one: []
        for one in (vector, planes, graph, single, numpy_world, numpy_kept)
        + (teams, team_planes, team_graph, team_state, one_team)
    }
    for _ in range(ROUNDS):
        for one, rates in measured.items():
            rates.append(one(seconds))
    for one, rates in measured.items():
        print(
            f"{one.__name__:>11}: {statistics.median(rates):>10,.0f} steps/s ({min(rates):,.0f} to {max(rates):,.0f})"
        )
    for one in (numpy_world, numpy_kept):
        ratios = [fast / slow for fast, slow in zip(measured[vector], measured[one], strict=True)]
        print(f"vector / {one.__name__}: {statistics.median(ratios):.0f} ({min(ratios):.0f} to {max(ratios):.0f})")
    quickest()


def quickest():
    """Of each kind the least time that a call took in a thousand: what it takes when nobody else has the core."""
    print("in the quickest hundredth of its calls:")
    random = np.random.default_rng(0)
    for name, observation in (("vector", "dict"), ("planes", "planes"), ("graph", "graph")):
        env, moves = batched(observation), iter(random.random((1000, LANES, 4)))
        _, info = env.reset(seed=0)
        _quickest(
            name,
            LANES,
            lambda env=env, info=info, moves=moves: env.step((info["action_mask"] * next(moves)).argmax(axis=1)),
        )
    for name, observation in (("teams", "dict"), ("team_planes", "planes"), ("team_graph", "graph")):
        env, moves = batched_teams(observation), iter(random.random((1000, LANES, ROBOTS, 4)))
        _, info = env.reset(seed=0)
        _quickest(
            name,
            LANES * ROBOTS,
            lambda env=env, info=info, moves=moves: env.step((info["action_mask"] * next(moves)).argmax(axis=2)),
        )
    for name, distances in (("numpy_world", None), ("numpy_kept", DISTANCES)):
        other = theirs(distances)
        masks, keys = [other.reset(0)[4]], iter(random.random((1000, 4)))
        _quickest(name, 1, lambda other=other, masks=masks, keys=keys: walk(other, masks, next(keys)))


def walk(other, masks, key):
    masks[0] = other.step((masks[0] * key).argmax())[4]


def _quickest(name, steps, call):
    times = []
    for _ in range(1000):
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    print(f"{name:>11}: {steps / sorted(times)[10]:>10,.0f} steps/s")


DISTANCES = shortest_paths()

if __name__ == "__main__":
    main(*map(float, sys.argv[1:]))
