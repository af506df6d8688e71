"""What is observed, and what an action names."""

from __future__ import annotations

import operator
from typing import Any

import numpy as np
from gymnasium import spaces

from .scenario import Scenario

#: Rows and columns that each step moves by, by the number of moves of a scenario; an action of ``control="step"`` is the
#: place in this list. For 4: south, west, east, north.
OFFSETS: dict[int, list[tuple[int, int]]] = {
    4: [(-1, 0), (0, -1), (0, 1), (1, 0)],
    8: [(-1, -1), (-1, 0), (-1, 1), (0, -1), (0, 1), (1, -1), (1, 0), (1, 1)],
}

#: What is observed and changes, in the order of the observation.
OBSERVED = ("log_odds", "probability", "precision", "weighted_sum", "distance", "position")


def observation_spaces(scenario: Scenario) -> dict[str, spaces.Space[Any]]:
    """The parts of an observation, by name; they are documented with :class:`dragnet.SearchEnv`."""
    cells = scenario.shape
    last = np.array(cells, dtype=np.int32) - 1
    return {
        "log_odds": spaces.Box(-np.inf, np.inf, cells, np.float64),
        "probability": spaces.Box(0.0, 1.0, cells, np.float32),
        "precision": spaces.Box(0.0, np.inf, cells, np.float64),
        "weighted_sum": spaces.Box(-np.inf, np.inf, cells, np.float64),
        "distance": spaces.Box(0.0, np.inf, cells, np.float32),
        "position": spaces.Box(np.zeros(2, dtype=np.int32), last, dtype=np.int32),
        "traversable": spaces.Box(0, 1, cells, np.int8),
    }


def action_space(scenario: Scenario, control: str) -> spaces.Discrete:
    """Cells for ``control="waypoint"``, steps for ``control="step"``."""
    if control == "step":
        return spaces.Discrete(len(OFFSETS[scenario.connectivity]))
    rows, columns = scenario.shape
    return spaces.Discrete(rows * columns)


def as_action(action: object, of: str = "action") -> int:
    """An action as the integer that it is."""
    try:
        return operator.index(action)  # type: ignore[arg-type]
    except TypeError:
        raise TypeError(f"{of} {action!r} of type {type(action).__name__}; allowed is an integer") from None


def as_seed(seed: object) -> int:
    """A seed as the episode's: 64 bits."""
    number = as_action(seed, "seed")
    if not 0 <= number < 2**64:
        raise ValueError(f"seed {number}; allowed are 0 to 2**64 - 1")
    return number


def check_options(options: dict[str, Any] | None, known: list[str]) -> None:
    """Refuses options that would otherwise be ignored."""
    for name in options or {}:
        if name not in known:
            allowed = ", ".join(known) if known else "none"
            raise ValueError(f"option {name!r}; allowed is {allowed}")
