"""Multi-robot active search: the simulator and the policies of Dragnet from Python.

A scenario file (or a :class:`Scenario`) is what all of this starts from:

- :class:`SearchEnv`: one robot, a Gymnasium environment, registered as ``dragnet/Search-v0``;
- :class:`SearchVectorEnv`: many of them side by side, batched in Rust;
- :func:`parallel_env`: a team, a PettingZoo parallel environment;
- :class:`Policy`: our policies, as baselines; :func:`compare`: policies against each other;
- :func:`read_recording`: a recording as arrays.

Cells are numbered row by row: ``cell = row * columns + column``, row 0 in the south, column 0 in the west. Arrays of shape
``(rows, columns)`` are in that order, so that a picture of one wants ``origin="lower"``.
"""

import gymnasium as _gymnasium

from .comparison import Table, compare
from .env import SearchEnv
from .policy import Decision, Policy, policy_names
from .recording import Recording, read_recording
from .scenario import Scenario
from .spaces import OFFSETS
from .team_env import parallel_env
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
    "compare",
    "parallel_env",
    "policy_names",
    "read_recording",
]

_gymnasium.register(
    id="dragnet/Search-v0",
    entry_point="dragnet.env:SearchEnv",
    vector_entry_point="dragnet.vector_env:SearchVectorEnv",
)
