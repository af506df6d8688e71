"""Policies against each other."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _dragnet
from .choices import Control, Frame, ObservationKind, as_action, as_seed
from .observation import Arrays, Observer
from .scenario import Scenario, as_scenario

if TYPE_CHECKING:
    import pandas  # type: ignore[import-untyped]

#: A policy of one's own: from an observation and the mask of actions (int8) an action, or ``None`` to rest.
Decide = Callable[[Any, NDArray[np.int8]], "int | None"]


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

    def to_pandas(self) -> pandas.DataFrame:
        """The table as a data frame; raises ``ImportError`` without pandas."""
        import pandas

        return pandas.DataFrame(list(self))


def compare(
    scenarios: Scenario | str | os.PathLike[str] | Sequence[Scenario | str | os.PathLike[str]],
    policies: Sequence[str] | Mapping[str, str | Decide],
    *,
    seeds: int | Iterable[int] = 10,
    baseline: str | None = None,
    robots: int | None = None,
    density: float | None = None,
    budget_cells: int | None = None,
    observation: ObservationKind = "dict",
    frame: Frame = "map",
    control: Control = "waypoint",
) -> Table:
    """Compares policies over scenarios and seeds, as ``dragnet compare`` does: with the same objects, starts and noise for all.

    ``seeds`` is their number (from 0 on) or the seeds themselves; ``robots``, ``density`` and ``budget_cells`` replace what
    the scenarios say. A row a scenario and policy, in that order: means over the seeds and their standard errors of the area
    under F1 and the average recall over the budget, the path length to full recall (cells; in a *restricted* mean a search
    that does not get there counts as its budget), and milliseconds a decision.

    A policy is its name, or has parameters as in ``"path(path_length_weight=1)"``. The others are compared with the policy
    ``baseline``, by default the first: see :attr:`Table.differences`.

    In a mapping policies have names of their own, and one may be a callable: ``decide(observation, action_mask)`` returns an
    action, or ``None`` to rest. It sees and acts as in :class:`dragnet.SearchEnv` with this ``observation``, ``frame`` and
    ``control``; each robot of a team asks it with its own observation. If it has a method ``reset``, that is called with the
    seed before each episode. Named policies run on all cores, callables on one. An exception of a callable becomes a
    ``RuntimeError`` that says in which decision of which episode; an action that cannot be taken is a ``ValueError``, one that
    is no integer a ``TypeError``.
    """
    several = scenarios if isinstance(scenarios, (list, tuple)) else [scenarios]
    given = by_name(policies)
    chosen = []
    for scenario in map(as_scenario, several):
        if robots is not None:
            scenario = scenario.with_robots(robots)
        if density is not None:
            scenario = scenario.with_density(density)
        if budget_cells is not None:
            scenario = scenario.with_budget_cells(budget_cells)
        chosen.append(scenario)
    if baseline is not None and baseline not in given and not isinstance(policies, Mapping):
        baseline = _dragnet.policy_label(baseline)
    numbers = [as_seed(seed) for seed in (seeds if isinstance(seeds, Iterable) else range(as_action(seeds, "seeds")))]
    table, differences = Table(), Table()
    for scenario in chosen:
        competitors = [
            (name, policy if isinstance(policy, str) else Caller(name, policy, scenario, observation, frame, control))
            for name, policy in given.items()
        ]
        rows, compared = _dragnet.compare(
            [scenario.native], competitors, numbers, baseline, (observation, frame, control)
        )
        table.extend(rows)
        differences.extend(compared)
    table.differences = differences
    return table


def by_name(policies: Sequence[str] | Mapping[str, str | Decide]) -> dict[str, str | Decide]:
    if isinstance(policies, Mapping):
        for name, policy in policies.items():
            if not isinstance(name, str):
                raise TypeError(f"policies: name {name!r}; allowed is a text")
            if not isinstance(policy, str) and not callable(policy):
                raise TypeError(
                    f"policies[{name!r}] of type {type(policy).__name__}; allowed are a policy's name and a callable"
                )
        return dict(policies)
    if isinstance(policies, str) or not all(isinstance(policy, str) for policy in policies):
        raise TypeError(f"policies={policies!r}; allowed are a list of names, and a dict of names and callables")
    return {_dragnet.policy_label(policy): policy for policy in policies}


class Caller:
    """A callable that robots ask: makes its observations, and checks its actions."""

    def __init__(
        self,
        name: str,
        decide: Decide,
        scenario: Scenario,
        observation: ObservationKind,
        frame: Frame,
        control: Control,
    ):
        self._name = name
        self._decide = decide
        features = _dragnet.Batch(
            scenario.with_robots(1).native, 1, control, "found", "all_found", "stay", observation, frame
        ).features()
        self._observer = Observer(scenario, observation, frame, control, features)

    def reset(self, seed: int) -> None:
        reset = getattr(self._decide, "reset", None)
        if reset is not None:
            reset(seed)

    def __call__(self, arrays: Arrays, belief: Arrays | None, where: str) -> int | None:
        where = f"policy {self._name!r} {where}"
        mask = arrays["action_mask"][0].copy()
        observation = self._observer.take(self._observer.views(arrays), belief, 0)
        try:
            action = self._decide(observation, mask)
        except Exception as error:
            raise RuntimeError(f"{where}: {type(error).__name__}: {error}") from error
        if action is None:
            return None
        number = as_action(action, f"{where}: action")
        if not 0 <= number < len(mask):
            raise ValueError(f"{where}: action {number}: no such action; they are 0 to {len(mask) - 1}")
        if not mask[number]:
            raise ValueError(f"{where}: action {number}: it is masked; allowed are those whose action_mask is 1")
        return number
