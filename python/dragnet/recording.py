"""Recordings as arrays and plain records."""

from __future__ import annotations

import os
from dataclasses import dataclass
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
    #: ``"complete"``, ``"cut off"`` or ``"damaged: ..."``; what is whole is here in any case.
    ending: str
    #: Edge of a cell, metres.
    cell_meters: float
    #: Where a robot can be, bool.
    traversable: NDArray[np.bool_]
    #: Where an object can be, bool.
    searched: NDArray[np.bool_]
    #: Probability of an object before the first look, float32.
    prior: NDArray[np.float32]
    #: Log-odds at the end, of all that was observed, nats, float64; ``-inf`` where nothing is searched.
    log_odds: NDArray[np.float64]
    #: Digest of all evidence, 32 hexadecimal digits.
    digest: str
    #: One entry an observation: ``time_seconds`` (float64), ``robot`` (int64; 0 is a person) and ``cell`` (int64).
    observations: dict[str, NDArray[Any]]
    #: One entry a reading: ``observation`` (its place there), ``cell``, ``value`` and ``variance`` (float32).
    readings: dict[str, NDArray[Any]]
    #: Plans as they came: ``time_seconds``, ``robot``, ``decision`` and ``path`` (cells still to be entered).
    plans: list[dict[str, Any]]
    #: Signs of life: ``time_seconds``, ``robot``, ``activity``, ``cell``, ``path_meters`` and ``digest``.
    heartbeats: list[dict[str, Any]]
    #: How the mission stood: ``time_seconds``, ``declared`` cells with their ``probability``, ``observations``,
    #: ``expected_undeclared`` and ``digest``.
    statuses: list[dict[str, Any]]

    def path(self, robot: int) -> NDArray[np.int64]:
        """Every cell that a robot has looked from, in order."""
        return self.observations["cell"][self.observations["robot"] == robot]


def read_recording(path: str | os.PathLike[str]) -> Recording:
    """Reads a recording (MCAP) that ``dragnet run`` has written. One that was cut off is read as far as it is whole.

    Raises ``OSError`` if the file cannot be read and ``ValueError`` if it is no recording of ours.
    """
    return Recording(**_dragnet.read_recording(Path(path)))
