"""The same world in NumPy, as one would write it: what the benchmark measures ours against, and nothing else uses it.

One robot moves to 4 neighbors, sees all cells within a Manhattan radius, and believes what Bayes says. Lengths of shortest
paths are searched anew from each cell that it enters, or, if they are given for all pairs of cells, looked up as ours are.
"""

import numpy as np

OFFSETS = np.array([(-1, 0), (0, -1), (0, 1), (1, 0)])
TAU = 0.95


class NumpySearch:
    """An environment with the observations, the reward (entropy removed) and the measures of ``dragnet.SearchEnv``."""

    def __init__(self, rows, columns, radius, noise_variance, density, budget_cells, distances=None):
        self.shape = (rows, columns)
        self.distances = distances
        self.density = density
        self.budget_cells = budget_cells
        offsets = np.mgrid[-radius : radius + 1, -radius : radius + 1].reshape(2, -1).T
        far = np.abs(offsets).sum(axis=1)
        self.offsets = offsets[far <= radius]
        far = far[far <= radius]
        self.variance = np.where(far == 0, noise_variance / 5, noise_variance * far**2).astype(np.float64)

    def reset(self, seed):
        self.random = np.random.default_rng(seed)
        self.truth = self.random.random(self.shape) < self.density
        self.position = self.random.integers(0, self.shape)
        self.log_odds = np.full(self.shape, np.log(self.density / (1 - self.density)))
        self.precision = np.zeros(self.shape)
        self.weighted_sum = np.zeros(self.shape)
        self.entropy = self._entropy()
        self.way = 0
        return self._look()

    def step(self, action):
        self.position = self.position + OFFSETS[action]
        self.way += 1
        return self._look()

    def _look(self):
        cells = self.position + self.offsets
        on_map = ((cells >= 0) & (cells < self.shape)).all(axis=1)
        rows, columns = cells[on_map].T
        variance = self.variance[on_map]
        value = self.truth[rows, columns] + self.random.standard_normal(len(rows)) * np.sqrt(variance)
        self.precision[rows, columns] += 1 / variance
        self.weighted_sum[rows, columns] += value / variance
        self.log_odds[rows, columns] += value / variance - 0.5 / variance
        before, self.entropy = self.entropy, self._entropy()
        found = self.log_odds >= np.log(TAU / (1 - TAU))
        hits, objects = np.count_nonzero(found & self.truth), np.count_nonzero(self.truth)
        f1 = 2 * hits / max(np.count_nonzero(found) + objects, 1)
        beside = self.position + OFFSETS
        observation = {
            "log_odds": self.log_odds.copy(),
            "probability": (0.5 * (1 + np.tanh(0.5 * self.log_odds))).astype(np.float32),
            "precision": self.precision.copy(),
            "weighted_sum": self.weighted_sum.copy(),
            "distance": self._distance(),
            "position": self.position.copy(),
        }
        mask = ((beside >= 0) & (beside < self.shape)).all(axis=1)
        return observation, before - self.entropy, hits == objects, self.way >= self.budget_cells, mask, f1

    def _distance(self):
        """Length of the shortest path to each cell: a wave that spreads by one cell at a time."""
        if self.distances is not None:
            return self.distances[self.position[0] * self.shape[1] + self.position[1]].copy()
        distance = np.full(self.shape, np.inf, dtype=np.float32)
        reached = np.zeros((self.shape[0] + 2, self.shape[1] + 2), dtype=bool)
        inside = reached[1:-1, 1:-1]
        inside[tuple(self.position)] = True
        length, new = 0, inside.copy()
        while new.any():
            distance[new] = length
            length += 1
            beside = reached[:-2, 1:-1] | reached[2:, 1:-1] | reached[1:-1, :-2] | reached[1:-1, 2:]
            new = beside & ~inside
            inside |= new
        return distance

    def _entropy(self):
        far = np.abs(self.log_odds)
        odds = np.exp(-far)
        return np.sum(np.log1p(odds) + far * odds / (1 + odds))
