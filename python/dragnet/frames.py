"""The columns of a recording's data frames: one row a thing, one column a quantity."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from .recording import Recording

Columns = Mapping[str, NDArray[Any] | list[Any]]


def _cells(recording: Recording) -> Columns:
    cells = np.arange(recording.traversable.size)
    row, column = np.divmod(cells, recording.traversable.shape[1])
    x, y = np.array([recording.position(cell) for cell in range(len(cells))]).T
    places = {"cell": cells, "row": row, "column": column, "x_meters": x, "y_meters": y}
    names = ("traversable", "searched", "prior", "log_odds", "probability")
    return places | {name: getattr(recording, name).ravel() for name in names}


def _observations(recording: Recording) -> Columns:
    return recording.observations


def _readings(recording: Recording) -> Columns:
    place, seen = recording.readings["observation"], recording.observations
    own = {name: recording.readings[name] for name in ("cell", "value", "variance")}
    of_observation = {"time_seconds": seen["time_seconds"][place], "robot": seen["robot"][place]}
    return {"observation": place, **of_observation, "observed_from": seen["cell"][place], **own}


def _plans(recording: Recording) -> Columns:
    lengths = [len(plan["path"]) for plan in recording.plans]
    columns = {
        name: np.repeat(_column(recording.plans, name), lengths) for name in ("time_seconds", "robot", "decision")
    }
    step = np.concatenate([np.arange(length) for length in lengths] or [np.arange(0)])
    return columns | {"step": step, "cell": _joined(recording.plans, "path", np.int64)}


def _heartbeats(recording: Recording) -> Columns:
    names = ("time_seconds", "robot", "activity", "cell", "path_meters", "digest")
    return {name: _column(recording.heartbeats, name) for name in names}


def _statuses(recording: Recording) -> Columns:
    names = ("time_seconds", "observations", "expected_remaining", "digest")
    count = [len(status["declared"]) for status in recording.statuses]
    return {"declared": count} | {name: _column(recording.statuses, name) for name in names}


def _declared(recording: Recording) -> Columns:
    lengths = [len(status["declared"]) for status in recording.statuses]
    return {
        "time_seconds": np.repeat(_column(recording.statuses, "time_seconds"), lengths),
        "cell": _joined(recording.statuses, "declared", np.int64),
        "probability": _joined(recording.statuses, "probability", np.float64),
    }


def _column(records: Sequence[Mapping[str, Any]], name: str) -> list[Any]:
    return [record[name] for record in records]


def _joined(records: Sequence[Mapping[str, Any]], name: str, dtype: type[np.generic]) -> NDArray[Any]:
    return np.concatenate([np.zeros(0, dtype), *_column(records, name)])


#: By their names: see :meth:`Recording.to_pandas`.
TABLES: dict[str, Callable[[Recording], Columns]] = {
    "cells": _cells,
    "observations": _observations,
    "readings": _readings,
    "plans": _plans,
    "heartbeats": _heartbeats,
    "statuses": _statuses,
    "declared": _declared,
}
