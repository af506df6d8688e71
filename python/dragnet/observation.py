"""What is observed, and what an action names."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from .choices import Control, Frame, ObservationKind
from .scenario import Scenario

#: Rows and columns that each step moves by, by the number of moves of a scenario; an action of ``control="step"`` is the
#: place in this list. For 4: south, west, east, north.
OFFSETS: dict[int, list[tuple[int, int]]] = {
    4: [(-1, 0), (0, -1), (0, 1), (1, 0)],
    8: [(-1, -1), (-1, 0), (-1, 1), (0, -1), (0, 1), (1, -1), (1, 0), (1, 1)],
}

_NO_EDGES: tuple[NDArray[np.int64], NDArray[np.float32]] = (np.zeros((2, 0), np.int64), np.zeros((0, 1), np.float32))

#: Features of cells in a state; distances are those of one robot and not among them.
_STATE_FEATURES = 5

Arrays = dict[str, NDArray[Any]]


def action_space(scenario: Scenario, control: Control) -> spaces.Discrete:
    """Cells for ``control="waypoint"``, steps for ``control="step"``."""
    if control == "step":
        return spaces.Discrete(len(OFFSETS[scenario.connectivity]))
    rows, columns = scenario.shape
    return spaces.Discrete(rows * columns)


def state_space(scenario: Scenario) -> spaces.Box:
    """What all robots of a team know together: features of cells, and a plane for each robot."""
    return spaces.Box(0.0, 1.0, (_STATE_FEATURES + scenario.robots, *scenario.shape), np.float32)


class Observer:
    """Makes observations of the arrays that the native part writes, for any number of robots at once."""

    def __init__(
        self,
        scenario: Scenario,
        kind: ObservationKind,
        frame: Frame,
        control: Control,
        features: list[str],
    ):
        self.kind = kind
        self.features = features
        self._scenario = scenario
        self._is_centered = frame == "robot" and kind != "belief"
        self._actions = int(action_space(scenario, control).n)
        rows, columns = scenario.shape
        self._shape = (2 * rows - 1, 2 * columns - 1) if self._is_centered else (rows, columns)
        #: Planes of a robot without teammates are an array; all other observations are dicts.
        self.is_array = kind == "planes" and "teammates" not in features
        # The moves between cells and their lengths; graphs alone have them.
        self._edges, self._lengths = scenario.native.edges() if kind == "graph" else _NO_EDGES

    def space(self) -> spaces.Space[Any]:
        """The space of one robot's observations."""
        parts = getattr(self, f"_{self.kind}_spaces")()
        return parts["observation"] if self.is_array else spaces.Dict(parts)

    def views(self, arrays: Arrays) -> Arrays:
        """The parts of all robots' observations, as views of the arrays: the axes of the arrays before the last one come
        first. Of a belief, what is observed beside it."""
        lead = arrays["features"].shape[:-1]
        mask = {"action_mask": arrays["action_mask"]}
        if self.kind == "planes":
            planes = arrays["features"].reshape(*lead, len(self.features), *self._shape)
            return {"observation": planes} | ({} if self.is_array else mask)
        if self.kind == "graph":
            return {
                "x": arrays["features"].reshape(*lead, -1, len(self.features)),
                "edge_index": np.broadcast_to(self._edges, (*lead, *self._edges.shape)),
                "edge_attr": np.broadcast_to(self._lengths, (*lead, *self._lengths.shape)),
            } | mask
        if self.kind == "dict":
            planes = arrays["features"].reshape(*lead, len(self.features), *self._shape)
            parts = {name: planes[..., place, :, :] for place, name in enumerate(self.features)}
            if not self._is_centered:
                parts["position"] = arrays["position"]
            return parts | {"budget": arrays["budget"]} | mask
        if "teammates" in self.features:
            mask["teammates"] = arrays["features"].reshape(*lead, len(self.features), *self._shape)[..., -1, :, :]
        return mask

    def take(self, views: Arrays, belief: Arrays | None, place: int | tuple[int, int]) -> Any:
        """The observation of one robot, by its place in the axes that come first, in arrays of its own; of a belief, if that
        is what is observed."""
        parts = {name: view[place].copy() for name, view in views.items()}
        if belief is not None:
            parts = belief | parts
        return parts["observation"] if self.is_array else parts

    def _mask_space(self) -> spaces.Box:
        return spaces.Box(0, 1, (self._actions,), np.int8)

    def _dict_spaces(self) -> dict[str, spaces.Space[Any]]:
        parts: dict[str, spaces.Space[Any]] = {
            name: spaces.Box(0.0, 1.0, self._shape, np.float32) for name in self.features
        }
        if not self._is_centered:
            parts["position"] = spaces.Box(0.0, 1.0, (2,), np.float32)
        parts["budget"] = spaces.Box(0.0, 1.0, (1,), np.float32)
        return parts | {"action_mask": self._mask_space()}

    def _planes_spaces(self) -> dict[str, spaces.Space[Any]]:
        planes = spaces.Box(0.0, 1.0, (len(self.features), *self._shape), np.float32)
        return {"observation": planes, "action_mask": self._mask_space()}

    def _graph_spaces(self) -> dict[str, spaces.Space[Any]]:
        rows, columns = self._scenario.shape
        lowest = [-1.0 if self._is_centered and name in ("row", "column") else 0.0 for name in self.features]
        low = np.broadcast_to(np.array(lowest, dtype=np.float32), (rows * columns, len(self.features)))
        return {
            "x": spaces.Box(low, np.ones_like(low), dtype=np.float32),
            "edge_index": spaces.Box(0, rows * columns - 1, self._edges.shape, np.int64),
            "edge_attr": spaces.Box(0.0, 2.0, (self._edges.shape[1], 1), np.float32),
            "action_mask": self._mask_space(),
        }

    def _belief_spaces(self) -> dict[str, spaces.Space[Any]]:
        cells = self._scenario.shape
        last = np.array(cells, dtype=np.int64) - 1
        parts: dict[str, spaces.Space[Any]] = {
            "log_odds": spaces.Box(-np.inf, np.inf, cells, np.float64),
            "probability": spaces.Box(0.0, 1.0, cells, np.float32),
            "precision": spaces.Box(0.0, np.inf, cells, np.float64),
            "weighted_sum": spaces.Box(-np.inf, np.inf, cells, np.float64),
            "distance": spaces.Box(0.0, np.inf, cells, np.float32),
            "traversable": spaces.Box(0, 1, cells, np.int8),
            "position": spaces.Box(np.zeros(2, dtype=np.int64), last, dtype=np.int64),
            "action_mask": self._mask_space(),
        }
        if "teammates" in self.features:
            parts["teammates"] = spaces.Box(0.0, 1.0, cells, np.float32)
        return parts
