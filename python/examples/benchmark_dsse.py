"""The greedy policy of DSSE (Drone Swarm Search Environment, PyPI DSSE) on the benchmark.

Usage: python benchmark_dsse.py [TRACK] [RESULT]

There each drone rushes to the cell of greatest probability and searches it, and decides anew in every step. Written anew from this
description, with what is different here: cells that are declared already are left out, since objects stay where they are; a robot
observes in every cell that it enters, so that nothing is a search of its own; among equally probable cells it takes the nearest; and
its paths lead around obstacles. Of several drones the kth takes the kth greatest there; here a robot does not know its number, so
that this is for the tracks of one robot.
"""

import sys

import numpy as np

import dragnet

#: Probability from which a cell is declared.
DECLARED = 0.95


class Rush:
    """Steps toward the most probable cell that is not declared."""

    def __init__(self):
        self._map = b""
        self._distances = {}

    def __call__(self, belief, action_mask):
        traversable, distance = belief["traversable"].astype(bool), belief["distance"]
        row, column = belief["position"]
        reachable = traversable & np.isfinite(distance)
        reachable[row, column] = False
        probability = np.where(reachable & (belief["probability"] < DECLARED), belief["probability"], -1.0)
        best = probability.max()
        if best < 0.0 or not action_mask.any():
            return None
        nearest = np.where(probability == best, distance, np.inf).argmin()
        steps = self._steps_to(int(nearest), traversable)
        around = [
            steps[row + down, column + right] if free else np.inf
            for (down, right), free in zip(dragnet.OFFSETS[4], action_mask, strict=True)
        ]
        return int(np.argmin(around))

    def _steps_to(self, cell, traversable):
        """Steps to a cell from every other, breadth first; kept for each cell of a map."""
        if self._map != traversable.tobytes():
            self._map, self._distances = traversable.tobytes(), {}
        if cell not in self._distances:
            steps = np.full(traversable.shape, np.inf)
            front = np.zeros_like(traversable)
            front[divmod(cell, traversable.shape[1])] = True
            count = 0
            while front.any():
                steps[front] = count
                wave = np.pad(front, 1)
                spread = wave[:-2, 1:-1] | wave[2:, 1:-1] | wave[1:-1, :-2] | wave[1:-1, 2:]
                front = spread & traversable & np.isinf(steps)
                count += 1
            self._distances[cell] = steps
        return self._distances[cell]


def main(track="single", out=None):
    result = dragnet.benchmark.run(track, {"dsse-greedy": Rush()}, observation="belief", control="step", out=out)
    for row in result.summary:
        cells, sem = row["cells_to_full_recall_restricted_mean"], row["cells_to_full_recall_restricted_sem"]
        print(f"{row['group']:>22}: {cells:.1f} ± {sem:.1f} cells, {row['reached']} of {row['episodes']} reached")
    return result


if __name__ == "__main__":
    main(*sys.argv[1:3])
