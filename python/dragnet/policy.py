"""Our policies, as baselines for others."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _dragnet
from .observation import OFFSETS
from .scenario import Scenario, as_scenario

_DTYPES: dict[str, type[np.generic]] = {
    "log_odds": np.float64,
    "precision": np.float64,
    "weighted_sum": np.float64,
    "traversable": np.int8,
}


def policy_names() -> list[str]:
    """Names of all policies."""
    return _dragnet.policy_names()


@dataclass(frozen=True)
class Decision:
    """What a policy decided, and from what."""

    #: The cell to go to, by number: an action of ``control="waypoint"``. The robot's own if there is nowhere to go or
    #: nothing is worth a look.
    waypoint: int
    #: The first step on the way there: an action of ``control="step"``; ``None`` if the robot is to rest.
    step: int | None
    #: Cells entered on the way, the waypoint last, int64.
    path: NDArray[np.int64]
    #: What the policy maximized, in units of its own, shape ``(rows, columns)``, float64; ``-inf`` where it cannot go.
    scores: NDArray[np.float64]


class Policy:
    """A policy of ours, asked with the belief of a robot: ``policy(env.belief())``, whatever the environment observes.

    With the scenario that the belief is of it decides as the robots of ``dragnet run`` do: with the scenario's sensor,
    moves and, if the scenario names this policy, parameters. Without, it takes the defaults of a scenario: a sensor of
    radius 5 and moves to 4 neighbors. Teammates' plans are not observed and do not count.

    ``seed`` is that of the episode: random choices are then those of robot number ``robot``. ``weights`` is a file of
    weights for ``"gnn"``, with a scenario.
    """

    def __init__(
        self,
        name: str,
        scenario: Scenario | str | os.PathLike[str] | None = None,
        *,
        weights: str | os.PathLike[str] | None = None,
        seed: int = 0,
        robot: int = 1,
    ):
        self.name = name
        given = None if scenario is None else as_scenario(scenario)
        self._connectivity = 4 if given is None else given.connectivity
        self._native = _dragnet.Policy(
            name, None if given is None else given.native, None if weights is None else Path(weights), seed, robot
        )

    def reset(self, seed: int) -> None:
        """Begins anew, with the random choices of an episode's seed."""
        self._native.reset(seed)

    def __call__(self, belief: Mapping[str, Any]) -> Decision:
        """Decides. Raises ``ValueError`` or ``TypeError`` that says which part of the belief is wrong."""
        parts = {name: _checked(belief, name, dtype) for name, dtype in _DTYPES.items()}
        shape = parts["log_odds"].shape
        for name, part in parts.items():
            if part.ndim != 2 or part.shape != shape:
                raise ValueError(
                    f"belief[{name!r}] of shape {part.shape}; allowed is (rows, columns), as of log_odds: {shape}"
                )
        row, column = _position(belief)
        waypoint, path, scores = self._native.decide(**parts, position=(row, column))
        step = None
        if len(path):
            next_row, next_column = divmod(int(path[0]), shape[1])
            step = OFFSETS[self._connectivity].index((next_row - row, next_column - column))
        return Decision(waypoint, step, path, scores.reshape(shape))


def _checked(belief: Mapping[str, Any], name: str, dtype: type[np.generic]) -> NDArray[Any]:
    if not isinstance(belief, Mapping):
        raise TypeError(f"belief of type {type(belief).__name__}; allowed is what belief() of an environment returns")
    if name not in belief:
        raise ValueError(f"belief without {name!r}; allowed is what belief() of an environment returns")
    part = belief[name]
    if not isinstance(part, np.ndarray) or part.dtype != dtype:
        found = f"dtype {part.dtype}" if isinstance(part, np.ndarray) else f"type {type(part).__name__}"
        raise TypeError(f"belief[{name!r}] of {found}; allowed is an array of dtype {np.dtype(dtype)}")
    if dtype is np.float64 and np.isnan(part).any():
        raise ValueError(f"belief[{name!r}] holds a NaN at {tuple(np.argwhere(np.isnan(part))[0].tolist())}")
    return part


def _position(belief: Mapping[str, Any]) -> tuple[int, int]:
    position = np.asarray(belief.get("position"))
    if position.dtype.kind not in "iu" or position.shape != (2,):
        raise ValueError("belief['position']: allowed are two integers, row and column")
    return int(position[0]), int(position[1])
