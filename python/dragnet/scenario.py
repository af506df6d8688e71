"""Scenarios: what is searched, by whom, with what, for how long."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from . import _dragnet


def scenarios() -> dict[str, str]:
    """The scenarios that come with the package: what each is, by its name. ``Scenario.load`` and environments take the names."""
    return dict(_dragnet.scenarios())


class Scenario:
    """A search that can be run: with a seed, it is an episode.

    Made by :meth:`load` or :meth:`from_text`; never changed, only derived from. Bad input raises ``ValueError`` with file,
    line, what is there and what is allowed; a file that is missing raises ``FileNotFoundError``.
    """

    def __init__(self, native: _dragnet.Scenario, changes: tuple[tuple[str, object], ...] = ()):
        if not isinstance(native, _dragnet.Scenario):
            raise TypeError("use Scenario.load(path) or Scenario.from_text(text)")
        self.native = native
        # What has been changed since it was read, in order: enough to make it again.
        self._changes = changes

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Scenario:
        """Reads a scenario file (TOML) and the files that it names, or one that comes with the package, by its name: see
        :func:`scenarios`. A file of that name goes first."""
        return cls(_dragnet.Scenario.load(Path(path)))

    @classmethod
    def from_text(cls, text: str, path: str | os.PathLike[str] = "scenario.toml") -> Scenario:
        """A scenario from its text, as if read from a path: files that it names are relative to the path's folder."""
        return cls(_dragnet.Scenario.from_text(text, Path(path)))

    def with_robots(self, count: int) -> Scenario:
        """So many robots instead, at least 1."""
        return self._changed("with_robots", count)

    def with_density(self, density: float) -> Scenario:
        """An object in each searched cell with this probability instead, above 0 and below 1."""
        return self._changed("with_density", density)

    def with_budget_cells(self, cells: int) -> Scenario:
        """A budget of this way (cells) for each robot instead of all budgets, at least 1."""
        return self._changed("with_budget_cells", cells)

    def with_policy(self, name: str) -> Scenario:
        """Every robot with this policy instead, as in ``"path"`` or ``"path(path_length_weight=1)"``: see :func:`policy_names`."""
        return self._changed("with_policy", name)

    def _changed(self, change: str, value: object) -> Scenario:
        native = getattr(self.native, change)(value)
        return Scenario(native, (*self._changes, (change, value)))

    @property
    def name(self) -> str:
        """Name of the mission."""
        return self.native.name

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the map."""
        return self.native.rows, self.native.columns

    @property
    def cell_meters(self) -> float:
        """Edge of a cell, meters."""
        return self.native.cell_meters

    @property
    def robots(self) -> int:
        """Robots in the team."""
        return self.native.robots

    @property
    def connectivity(self) -> int:
        """To how many neighbors a robot moves: 4 or 8."""
        return self.native.connectivity

    @property
    def detection_threshold(self) -> float:
        """A cell whose probability reaches this counts as found."""
        return self.native.detection_threshold

    @property
    def traversable(self) -> NDArray[np.bool_]:
        """Where a robot can be, shape ``(rows, columns)``."""
        return self.native.traversable

    @property
    def searched(self) -> NDArray[np.bool_]:
        """Where an object can be, shape ``(rows, columns)``."""
        return self.native.searched

    @property
    def prior(self) -> NDArray[np.float64]:
        """Probability of an object before the first look, shape ``(rows, columns)``."""
        return self.native.prior

    def __repr__(self) -> str:
        return repr(self.native)

    def __deepcopy__(self, memo: dict[int, object]) -> Scenario:
        return self

    def __reduce__(self) -> tuple[object, tuple[object, ...]]:
        return _again, (*self.native.source, self._changes)


def _again(text: str, path: Path, changes: tuple[tuple[str, object], ...]) -> Scenario:
    scenario = Scenario.from_text(text, path)
    for change, value in changes:
        scenario = scenario._changed(change, value)
    return scenario


def as_scenario(scenario: Scenario | str | os.PathLike[str]) -> Scenario:
    """A scenario as it is, or the one of a file."""
    if isinstance(scenario, Scenario):
        return scenario
    if isinstance(scenario, (str, os.PathLike)):
        return Scenario.load(scenario)
    raise TypeError(f"scenario of type {type(scenario).__name__}; allowed is a Scenario or the path of a file")
