"""The benchmark: policies on frozen tracks, and results that others can verify.

``docs/benchmark.md`` has the tracks, the rules and a table of results.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from . import _dragnet
from .choices import Control, Frame, ObservationKind, as_count, as_seed
from .comparison import Caller, Decide, Table, by_name
from .scenario import Scenario

__all__ = ["Result", "Track", "run", "tracks", "verify"]


class Track(NamedTuple):
    """A frozen set of searches and seeds."""

    name: str
    version: int
    #: A summary.
    about: str
    #: Number of episodes for each policy.
    episodes: int


def tracks() -> list[Track]:
    """All tracks."""
    return [Track(*track) for track in _dragnet.benchmark_tracks()]


class Result:
    """The results of policies on a track, as the command line writes them; made by :func:`run` and :meth:`read`."""

    def __init__(self, native: _dragnet.BenchmarkResult):
        self._native = native

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> Result:
        """Reads a file of :meth:`write` or of ``dragnet benchmark --out``.

        Raises ``ValueError`` if it was changed or damaged, is of another version, or of a track that has another digest here.
        """
        return cls(_dragnet.BenchmarkResult.read(Path(path)))

    def write(self, path: str | os.PathLike[str]) -> None:
        """Writes the file (JSON); raises ``FileExistsError`` rather than to replace one."""
        if Path(path).exists():
            raise FileExistsError(f"{os.fspath(path)}: exists already; no result is overwritten")
        self._native.write(Path(path))

    @property
    def track(self) -> str:
        """Name of the track."""
        return self._native.track

    @property
    def digest(self) -> str:
        """Digest over the whole result."""
        return self._native.digest

    @property
    def summary(self) -> Table:
        """A row for each policy and group of searches; the group ``"all"`` is the whole track."""
        return Table(self._native.summary())

    def to_json(self) -> str:
        """The text of the file."""
        return self._native.json()


def run(
    track: str,
    policies: Sequence[str] | Mapping[str, str | Decide],
    *,
    observation: ObservationKind = "dict",
    frame: Frame = "map",
    control: Control = "waypoint",
    out: str | os.PathLike[str] | None = None,
) -> Result:
    """Measures policies on a track, as ``dragnet benchmark`` does; writes the result to ``out``, if given.

    Policies are given, see and act as in :func:`dragnet.compare`: a callable ``decide(observation, action_mask)`` returns an
    action, or ``None`` to rest; if it has a method ``reset``, that is called with the seed before each episode. Named policies
    run on all cores, callables on one.
    """
    if out is not None and Path(out).exists():
        raise FileExistsError(f"{os.fspath(out)}: exists already; no result is overwritten")
    native = _dragnet.Track(track)
    interface = (observation, frame, control)
    measured = [
        (name, policy if isinstance(policy, str) else _callers(native, name, policy, interface))
        for name, policy in by_name(policies).items()
    ]
    result = Result(native.run(measured, interface))
    if out is not None:
        result.write(out)
    return result


def verify(
    result: Result | str | os.PathLike[str],
    callables: Mapping[str, Decide] | None = None,
    *,
    sample: int | None = None,
    seed: int = 0,
) -> Table:
    """Runs the episodes of a result again, or ``sample`` of them drawn with ``seed``; returns a row for each that differs.

    Each of its policies that was a callable has to be given again, by its name; it sees and acts as it did then.
    """
    read = result if isinstance(result, Result) else Result.read(result)
    native = _dragnet.Track(read.track)
    given = dict(callables or {})
    interfaces = {name: interface for name, interface in read._native.policies() if interface is not None}
    missing = [name for name in interfaces if name not in given]
    if missing:
        raise ValueError(f"{', '.join(map(repr, missing))}: decided by a callable; pass it in callables to verify it")
    for name, decide in given.items():
        if name not in interfaces:
            raise ValueError(f"callables[{name!r}]: not of the result; allowed are {', '.join(interfaces) or 'none'}")
        if not callable(decide):
            raise TypeError(f"callables[{name!r}] of type {type(decide).__name__}; allowed is a callable")
    callers = [(name, _callers(native, name, given[name], interface)) for name, interface in interfaces.items()]
    size = None if sample is None else as_count(sample, "sample")
    return Table(read._native.verify(callers, size, as_seed(seed)))


def _callers(track: _dragnet.Track, name: str, decide: Decide, interface: tuple[str, str, str]) -> list[Any]:
    """What asks a callable on each search of a track."""
    observation, frame, control = interface
    return [
        Caller(name, decide, Scenario(native), observation, frame, control)  # type: ignore[arg-type]
        for native in track.scenarios()
    ]
