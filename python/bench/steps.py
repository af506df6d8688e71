"""Steps a second: 64 environments of 30 x 30 cells, ``control="step"``, against the same world in NumPy.

Usage: python steps.py [SECONDS]

The package has to be built with ``maturin develop --release``. Everything is measured in turn, several times over; medians
are printed, and lowest and highest. That both worlds are the same is checked first: after the same moves they have the same
precision in every cell and the same distances.
"""

import statistics
import sys
import time

import numpy as np
from numpy_search import NumpySearch

import dragnet

SIDE = 30
LANES = 64
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


def theirs():
    return NumpySearch(SIDE, SIDE, 5, 0.005, 0.01, 300, DISTANCES)


def check_same_world():
    ours, other = dragnet.SearchEnv(dragnet.Scenario.from_text(SCENARIO), control="step"), theirs()
    observation, info = ours.reset(seed=1)
    other.reset(seed=1)
    other.position = observation["position"].astype(np.int64)
    other.precision[:] = 0
    seen, *_ = other._look()
    random = np.random.default_rng(0)
    for _ in range(30):
        assert np.allclose(seen["precision"], observation["precision"], rtol=1e-4)
        assert np.array_equal(seen["distance"], observation["distance"])
        action = random.choice(np.flatnonzero(info["action_mask"]))
        observation, _, over, _, info = ours.step(action)
        seen, *_ = other.step(action)
        if over:
            break


def vector(seconds):
    env = dragnet.SearchVectorEnv(dragnet.Scenario.from_text(SCENARIO), LANES, control="step")
    random = np.random.default_rng(0)
    _, info = env.reset(seed=0)
    keys = random.random((64, LANES, 4))
    steps, start = 0, time.perf_counter()
    while time.perf_counter() - start < seconds:
        actions = (info["action_mask"] * keys[steps % 64]).argmax(axis=1)
        _, _, _, _, info = env.step(actions)
        steps += 1
    return steps * LANES / (time.perf_counter() - start)


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


def numpy_world(seconds):
    envs = [theirs() for _ in range(LANES)]
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
    measured = {"vector": [], "single": [], "numpy": []}
    for _ in range(ROUNDS):
        measured["vector"].append(vector(seconds))
        measured["numpy"].append(numpy_world(seconds))
        measured["single"].append(single(seconds))
    for name, rates in measured.items():
        print(f"{name:>7}: {statistics.median(rates):>10,.0f} steps/s ({min(rates):,.0f} to {max(rates):,.0f})")
    ratios = [fast / slow for fast, slow in zip(measured["vector"], measured["numpy"], strict=True)]
    print(f"  ratio: {statistics.median(ratios):.0f} ({min(ratios):.0f} to {max(ratios):.0f})")


DISTANCES = shortest_paths()

if __name__ == "__main__":
    main(*map(float, sys.argv[1:]))
