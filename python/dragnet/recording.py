"""Recordings as arrays and plain records."""

from __future__ import annotations

import os
from dataclasses import dataclass
from math import cos, sin
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _dragnet


@dataclass(frozen=True)
class Recording:
    """A mission as it was recorded. Cells are numbers, arrays of the map have the shape ``(rows, columns)``."""

    #: How the run was made: scenario, seed, version.
    run: dict[str, str]
    #: How it went; empty in a recording that was cut off.
    summary: dict[str, str]
    #: ``"complete"``, ``"cut off"`` or ``"damaged in ..."``; what is whole is here in any case.
    ending: str
    #: Edge of a cell, meters.
    cell_meters: float
    #: Pose of the map's south-western corner in the frame ``map``: x and y, meters, and yaw, radians.
    origin: tuple[float, float, float]
    #: Where a robot can be, bool.
    traversable: NDArray[np.bool_]
    #: Where an object can be, bool; at the end, with the cells that the operator added.
    searched: NDArray[np.bool_]
    #: Probability of an object before the first observation, float32; added cells included.
    prior: NDArray[np.float32]
    #: Log-odds at the end, of all that was observed, nats, float64; ``-inf`` where nothing is searched.
    log_odds: NDArray[np.float64]
    #: Digest of all evidence, 32 hexadecimal digits.
    digest: str
    #: One entry an observation: ``time_seconds`` (float64), ``robot`` (int64; 0 is the operator) and ``cell`` (int64).
    observations: dict[str, NDArray[Any]]
    #: One entry a reading: ``observation`` (its place there), ``cell``, ``value`` and ``variance`` (float32).
    readings: dict[str, NDArray[Any]]
    #: Plans as they came: ``time_seconds``, ``robot``, ``decision`` and ``path`` (cells still to be entered).
    plans: list[dict[str, Any]]
    #: Heartbeats: ``time_seconds``, ``robot``, ``activity``, ``cell``, ``path_meters`` and ``digest``.
    heartbeats: list[dict[str, Any]]
    #: How the mission stood: ``time_seconds``, ``declared`` cells with their ``probability``, ``observations``,
    #: ``expected_remaining`` and ``digest``.
    statuses: list[dict[str, Any]]

    def position(self, cell: int) -> tuple[float, float]:
        """The middle of a cell in the frame ``map``, meters."""
        row, column = divmod(int(cell), self.traversable.shape[1])
        along, up = (column + 0.5) * self.cell_meters, (row + 0.5) * self.cell_meters
        x, y, yaw = self.origin
        return x + cos(yaw) * along - sin(yaw) * up, y + sin(yaw) * along + cos(yaw) * up

    def path(self, robot: int) -> NDArray[np.int64]:
        """Every cell that a robot has looked from, in order."""
        cells: NDArray[np.int64] = self.observations["cell"][self.observations["robot"] == robot]
        return cells


def read_recording(path: str | os.PathLike[str]) -> Recording:
    """Reads a recording (MCAP) that ``dragnet run`` has written. Of one that was cut off or is
    damaged all that is whole is read.

    Raises ``OSError`` if the file cannot be read and ``ValueError`` if it is no recording of ours.
    """
    return Recording(**_dragnet.read_recording(Path(path)))
