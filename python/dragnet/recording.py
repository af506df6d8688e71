"""Recordings as arrays, plain records and data frames."""

from __future__ import annotations

import os
from dataclasses import dataclass
from math import cos, sin
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from . import _dragnet
from .frames import TABLES

if TYPE_CHECKING:
    import pandas  # type: ignore[import-untyped]

#: Data frames of a recording: see :meth:`Recording.to_pandas`.
RecordingTable = Literal["cells", "observations", "readings", "plans", "heartbeats", "statuses", "declared"]


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

    @property
    def probability(self) -> NDArray[np.float64]:
        """Probability of an object at the end, of all that was observed; 0 where nothing is searched."""
        with np.errstate(over="ignore"):
            probability: NDArray[np.float64] = 1.0 / (1.0 + np.exp(-self.log_odds))
        return probability

    def to_pandas(self, table: RecordingTable) -> pandas.DataFrame:
        """A part of the recording as a data frame, one row for each

        - ``"cells"``: cell: ``row``, ``column``, ``x_meters``, ``y_meters`` (its middle, in the frame ``map``),
          ``traversable``, ``searched``, ``prior``, ``log_odds`` and ``probability`` at the end;
        - ``"observations"``: observation: ``time_seconds``, ``robot`` (0 is the operator), ``cell``;
        - ``"readings"``: reading: ``observation`` (its row there), ``time_seconds``, ``robot`` and ``observed_from`` (cell) of that;
          ``cell``, ``value``, ``variance``;
        - ``"plans"``: cell of a plan: ``time_seconds``, ``robot``, ``decision``, ``step`` (from 0 on), ``cell``;
        - ``"heartbeats"``: heartbeat: ``time_seconds``, ``robot``, ``activity``, ``cell``, ``path_meters``, ``digest``;
        - ``"statuses"``: status of the mission: ``declared`` (how many cells), ``time_seconds``, ``observations``,
          ``expected_remaining``, ``digest``;
        - ``"declared"``: cell that a status declares: ``time_seconds``, ``cell``, ``probability``.

        ``cell`` joins them: ``recording.to_pandas("declared").merge(recording.to_pandas("cells"), on="cell")``.
        Raises ``ImportError`` without pandas.
        """
        if table not in TABLES:
            allowed = ", ".join(f'"{name}"' for name in TABLES)
            raise ValueError(f'table "{table}"; allowed are {allowed}')
        try:
            import pandas
        except ImportError:
            raise ImportError("Recording.to_pandas needs pandas: pip install 'dragnet[tables]'") from None
        return pandas.DataFrame(dict(TABLES[table](self)))

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
