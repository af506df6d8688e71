"""A policy learned from scratch in NumPy: policy gradient with a baseline (Williams, 1992), on the vector environment.

The policy is linear: each move has three features, and a softmax over their weighted sums chooses. It learns to go where
uncertainty is left, and to keep away from where it has been.

Usage: python learn.py
"""

import numpy as np

import dragnet

SCENARIO = """
name = "learning"
map = { shape = "all_traversable", rows = 16, columns = 16, cell_meters = 10.0 }
sensor.radius = 2
objects.density = 0.05
robots.start = "scattered"
mission.budget_meters = 1000.0
"""

LANES = 32
STEPS = 32
DISCOUNT = 0.9
RATE = 0.3


def features(observation, mask):
    """Of each move: entropy around the next cell, the same some cells ahead, and whether it was entered before.

    Shapes: ``observation`` is that of a vector environment, ``mask`` is ``(lanes, moves)``; the result is
    ``(lanes, moves, 3)``.
    """
    entropy = observation["entropy"].astype(np.float64)
    lanes, rows, columns = entropy.shape
    margin = 5
    padded = np.pad(entropy, ((0, 0), (margin, margin), (margin, margin)))
    # One reading from a cell itself has 20 times the precision of one from the radius of 2 cells.
    seen = np.pad(observation["observed"] > 0.945, ((0, 0), (margin, margin), (margin, margin)), constant_values=True)
    at = np.rint(observation["position"] * (rows - 1, columns - 1)).astype(np.int64) + margin
    lane = np.arange(lanes)
    diamond = [(north, east) for north in range(-2, 3) for east in range(-2, 3) if abs(north) + abs(east) <= 2]
    found = np.zeros((lanes, mask.shape[1], 3))
    for move, (north, east) in enumerate(dragnet.OFFSETS[4]):
        for kind, ahead in enumerate((1, 3)):
            row, column = at[:, 0] + ahead * north, at[:, 1] + ahead * east
            around = [padded[lane, row + up, column + right] for up, right in diamond]
            found[:, move, kind] = np.sum(around, axis=0)
        found[:, move, 2] = seen[lane, at[:, 0] + north, at[:, 1] + east]
    return found


def choose(weights, observation, mask, random):
    """Actions, and what the gradient of their log-probabilities is, shape ``(lanes, 3)``."""
    given = features(observation, mask)
    logits = np.where(mask == 1, given @ weights, -np.inf)
    chances = np.exp(logits - logits.max(axis=1, keepdims=True))
    chances /= chances.sum(axis=1, keepdims=True)
    actions = (chances.cumsum(axis=1) > random.random((len(mask), 1))).argmax(axis=1)
    expected = (chances[..., None] * given).sum(axis=1)
    return actions, given[np.arange(len(mask)), actions] - expected


def evaluate(weights, seed, episodes=64):
    """Mean recall when all is found or the budget is spent, over the first episode of each lane."""
    env = dragnet.SearchVectorEnv(dragnet.Scenario.from_text(SCENARIO), episodes, control="step")
    random = np.random.default_rng(seed)
    observation, info = env.reset(seed=1000)
    recalls = np.full(episodes, np.nan)
    while np.isnan(recalls).any():
        actions, _ = choose(weights, observation, info["action_mask"], random)
        observation, _, terminated, truncated, info = env.step(actions)
        ended = (terminated | truncated) & np.isnan(recalls)
        recalls[ended] = info["recall"][ended]
    return float(recalls.mean())


def main(updates=60, seed=0):
    env = dragnet.SearchVectorEnv(dragnet.Scenario.from_text(SCENARIO), LANES, control="step", reward="entropy")
    random = np.random.default_rng(seed)
    weights = np.zeros(3)
    before = evaluate(weights, seed)
    observation, info = env.reset(seed=seed)
    for _ in range(updates):
        rewards, gradients, ended = [], [], []
        for _ in range(STEPS):
            actions, gradient = choose(weights, observation, info["action_mask"], random)
            observation, reward, terminated, truncated, info = env.step(actions)
            rewards.append(reward)
            gradients.append(gradient)
            ended.append(terminated | truncated)
        returns = np.zeros((STEPS, LANES))
        after = np.zeros(LANES)
        for step in reversed(range(STEPS)):
            after = rewards[step] + DISCOUNT * after * ~ended[step]
            returns[step] = after
        # What an episode yields falls as it goes on: each step is compared with the same step of the other lanes.
        advantages = returns - returns.mean(axis=1, keepdims=True)
        advantages /= advantages.std() + 1e-9
        weights += RATE * (advantages[..., None] * np.array(gradients)).mean(axis=(0, 1))
    learned = evaluate(weights, seed)
    print(f"mean recall at the end: {before:.2f} at random, {learned:.2f} learned; weights {weights.round(2)}")
    return before, learned


if __name__ == "__main__":
    main()
