"""What robots plan, for pictures: the cells that they are still to enter."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .observation import OFFSETS
from .scenario import Scenario

_NOTHING: NDArray[np.int64] = np.zeros(0, dtype=np.int64)


@dataclass
class Plan:
    """One robot's."""

    #: Cells in the order in which they are to be entered, as ``show_plan`` was given them.
    cells: NDArray[np.int64] | None = None
    #: The waypoint of the last action.
    goal: int | None = None

    def take(self, goal: int | None, robot_cell: int, is_over: bool) -> None:
        """Follows a step: the goal of its action if that is a waypoint, and where the robot is now."""
        if is_over:
            self.cells, self.goal = None, None
            return
        self.goal = goal
        if self.cells is not None:
            passed = np.flatnonzero(self.cells == robot_cell)
            is_followed = len(passed) > 0 and goal in (None, int(self.cells[-1]))
            self.cells = self.cells[passed[0] + 1 :] if is_followed and passed[0] + 1 < len(self.cells) else None

    def ahead(self, distance: NDArray[np.float32], connectivity: int) -> NDArray[np.int64]:
        """Cells still to be entered, by the distances from the robot: see :func:`shortest_path`."""
        if self.cells is not None:
            return self.cells
        return _NOTHING if self.goal is None else shortest_path(distance, connectivity, self.goal)


def shortest_path(distance: NDArray[np.float32], connectivity: int, goal: int) -> NDArray[np.int64]:
    """Cells entered on the shortest path to a goal, by the distances from the robot (cells, shape ``(rows, columns)``): of
    equally short paths the one that the simulator takes. Empty where the robot is, and out of reach.
    """
    rows, columns = distance.shape
    at = divmod(goal, columns)
    path: list[int] = []
    while 0.0 < distance[at] < np.inf:
        path.append(at[0] * columns + at[1])
        # The offsets are in the order of cells: the first of equals is the smallest cell, as in the simulator.
        for down, right in OFFSETS[connectivity]:
            row, column = at[0] + down, at[1] + right
            if not (0 <= row < rows and 0 <= column < columns):
                continue
            cuts_corner = down and right and not np.isfinite([distance[row, at[1]], distance[at[0], column]]).all()
            if not cuts_corner and abs(distance[row, column] + np.hypot(down, right) - distance[at]) < 1e-3:
                at = (row, column)
                break
        else:
            return _NOTHING
    return np.array(path[::-1], dtype=np.int64)


def as_cells(cells: ArrayLike, scenario: Scenario) -> NDArray[np.int64]:
    """Cells as integers, each on the map."""
    array = np.asarray(cells)
    if array.ndim != 1 or (array.dtype.kind not in "iu" and array.size):
        raise TypeError(f"cells of dtype {array.dtype} and shape {array.shape}; allowed are integers, shape (cells,)")
    count = scenario.shape[0] * scenario.shape[1]
    for cell in array:
        if not 0 <= cell < count:
            raise ValueError(f"cell {cell}; allowed are 0 to {count - 1}")
    return array.astype(np.int64)
