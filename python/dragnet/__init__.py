"""Multi-robot active search: the simulator and the policies of Dragnet from Python.

A scenario (its file, the name of one of :func:`scenarios`, or a :class:`Scenario`) is what all of this starts from:

- :class:`SearchEnv`: one robot, a Gymnasium environment, registered as ``dragnet/Search-v0`` and, with the scenarios that come
  with the package, as ``dragnet/IceCreamCone-v0``, ``dragnet/OpenMap-v0`` and others;
- :class:`SearchVectorEnv`: many of them side by side, batched in Rust;
- :func:`parallel_env`: a team, a PettingZoo parallel environment;
- :class:`TeamVectorEnv`: many teams side by side, batched in Rust;
- :class:`Policy`: our policies, as baselines; :func:`compare`: policies, ours and your own, against each other; :mod:`benchmark`: the same on frozen tracks,
  with results that others can verify;
- :func:`read_recording`: a recording as arrays and data frames; :func:`plot`: a picture of it.

Cells are numbered row by row: ``cell = row * columns + column``, row 0 in the south, column 0 in the west. Arrays of shape
``(rows, columns)`` are in that order, so that a picture of one wants ``origin="lower"``.
"""

import gymnasium as _gymnasium

from . import benchmark
from ._dragnet import VERSION as __version__
from .comparison import Table, compare
from .env import SearchEnv
from .observation import OFFSETS
from .plot import plot
from .policy import Decision, Policy, policy_names
from .recording import Recording, read_recording
from .scenario import Scenario, scenarios
from .team_env import parallel_env
from .team_vector_env import TeamVectorEnv
from .vector_env import SearchVectorEnv

__all__ = [
    "OFFSETS",
    "Decision",
    "Policy",
    "Recording",
    "Scenario",
    "SearchEnv",
    "SearchVectorEnv",
    "Table",
    "TeamVectorEnv",
    "__version__",
    "benchmark",
    "compare",
    "parallel_env",
    "plot",
    "policy_names",
    "read_recording",
    "scenarios",
]

#: The scenario of each registered environment; ``scenario=`` replaces it.
_IDS = {
    "Search": "ice_cream_cone",
    "IceCreamCone": "ice_cream_cone",
    "OpenMap": "paper/all_traversable",
    "OpenAsterisk": "paper/open_asterisk",
    "FigureFour": "paper/figure_four",
    "Jersey": "jersey",
    "MissingPerson": "missing_person",
}

for _name, _scenario in _IDS.items():
    _gymnasium.register(
        id=f"dragnet/{_name}-v0",
        entry_point="dragnet.env:SearchEnv",
        vector_entry_point="dragnet.vector_env:SearchVectorEnv",
        # In the folder of what comes with the package: no file of the same name is in its way.
        kwargs={"scenario": f"dragnet:/{_scenario}.toml"},
    )
