"""Policies against each other."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Iterable, Sequence
from typing import Any

from . import _dragnet
from .scenario import Scenario, as_scenario
from .spaces import as_seed


class Table(list[dict[str, Any]]):
    """Rows with the columns of the command line's ``summary.csv``; ``None`` where nothing is known.

    ``differences`` holds those of ``differences.csv``: each other policy less the baseline, paired by seed, with 95 %
    bootstrap intervals.
    """

    differences: Table

    @property
    def columns(self) -> list[str]:
        """Names of the columns, in order."""
        return list(self[0]) if self else []

    def to_csv(self) -> str:
        """The table as CSV, a line of titles first."""
        text = io.StringIO()
        writer = csv.DictWriter(text, self.columns, lineterminator="\n")
        writer.writeheader()
        writer.writerows(self)
        return text.getvalue()


def compare(
    scenarios: Scenario | str | os.PathLike[str] | Sequence[Scenario | str | os.PathLike[str]],
    policies: Sequence[str],
    *,
    seeds: int | Iterable[int] = 10,
    baseline: str | None = None,
    robots: int | None = None,
    density: float | None = None,
    budget_cells: int | None = None,
) -> Table:
    """Compares policies over scenarios and seeds, as ``dragnet compare`` does, on all cores.

    ``seeds`` is their number (from 0 on) or the seeds themselves; ``robots``, ``density`` and ``budget_cells`` replace what
    the scenarios say. A row a scenario and policy, in that order: means over the seeds and their standard errors of the area
    under F1 and the average recall over the budget, the path length to full recall (cells), and milliseconds a decision.

    A policy is its name, or has parameters as in ``"path(path_length_weight=1)"``. The others are compared with the policy
    ``baseline``, by default the first: see :attr:`Table.differences`.
    """
    several = scenarios if isinstance(scenarios, (list, tuple)) else [scenarios]
    if isinstance(policies, str):
        raise TypeError(f"policies={policies!r}; allowed is a list of names")
    chosen = []
    for scenario in map(as_scenario, several):
        if robots is not None:
            scenario = scenario.with_robots(robots)
        if density is not None:
            scenario = scenario.with_density(density)
        if budget_cells is not None:
            scenario = scenario.with_budget_cells(budget_cells)
        chosen.append(scenario.native)
    numbers = range(seeds) if isinstance(seeds, int) else seeds
    rows, differences = _dragnet.compare(chosen, list(policies), [as_seed(seed) for seed in numbers], baseline)
    table = Table(rows)
    table.differences = Table(differences)
    return table
