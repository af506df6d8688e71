"""A team's search as a PettingZoo parallel environment."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from gymnasium import spaces
from gymnasium.utils import seeding
from numpy.typing import NDArray

from . import _dragnet, picture
from .scenario import Scenario, as_scenario
from .spaces import OBSERVED, action_space, as_action, as_seed, observation_spaces

if TYPE_CHECKING:
    from pettingzoo import ParallelEnv  # type: ignore[import-untyped]
else:
    try:
        from pettingzoo import ParallelEnv
    except ImportError:
        ParallelEnv = object

Observation = dict[str, NDArray[Any]]


class TeamEnv(ParallelEnv):
    """The environment of :func:`parallel_env`."""

    metadata = {"name": "dragnet_search_v0", "render_modes": ["rgb_array"], "render_fps": 10}

    def __init__(
        self,
        scenario: Scenario,
        control: str,
        reward: str,
        masked_action: str,
        crashes: Mapping[int, float],
        render_mode: str | None,
    ):
        picture.check_mode(render_mode)
        self.scenario = scenario
        self.render_mode = render_mode
        self._team = _dragnet.Team(scenario.native, control, reward, masked_action, dict(crashes))
        self._arrays = self._team.arrays()
        self._traversable = scenario.traversable.astype(np.int8)
        self.possible_agents = [f"robot_{number}" for number in range(1, scenario.robots + 1)]
        self.agents: list[str] = []
        self._places = {agent: place for place, agent in enumerate(self.possible_agents)}
        self._actions = np.zeros(scenario.robots, dtype=np.int64)
        self._ways: list[list[int]] = []
        self._random: np.random.Generator | None = None
        self._seed = 0
        self._observation_spaces: dict[str, spaces.Dict] = {}
        self._action_spaces: dict[str, spaces.Discrete] = {}
        for agent in self.possible_agents:
            actions = action_space(scenario, control)
            parts = observation_spaces(scenario)
            size = max(scenario.shape)
            parts["teammates"] = spaces.Box(-1, size - 1, (scenario.robots, 2), np.int32)
            parts["action_mask"] = spaces.Box(0, 1, (int(actions.n),), np.int8)
            self._observation_spaces[agent] = spaces.Dict(parts)
            self._action_spaces[agent] = actions

    def observation_space(self, agent: str) -> spaces.Dict:
        """That of :class:`dragnet.SearchEnv`, with ``teammates`` and ``action_mask``."""
        return self._observation_spaces[agent]

    def action_space(self, agent: str) -> spaces.Discrete:
        """Cells to head for, or steps."""
        return self._action_spaces[agent]

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Observation], dict[str, dict[str, Any]]]:
        """Begins an episode: the one of a seed, or the next one. There are no options."""
        if seed is not None:
            self._random, _ = seeding.np_random(as_seed(seed))
            self._seed = as_seed(seed)
        else:
            if self._random is None:
                self._random, _ = seeding.np_random()
            self._seed = int(self._random.integers(2**63))
        self._team.reset(self._seed)
        self.agents = list(self.possible_agents)
        self._ways = [[self._cell(place)] for place in range(len(self.possible_agents))]
        return self._observations(self.agents), self._infos(self.agents)

    def step(
        self, actions: Mapping[str, int]
    ) -> tuple[dict[str, Observation], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]]:
        """Every robot that is still in ``agents`` takes its action, all at the same time."""
        if not self.agents:
            raise RuntimeError("step without agents: the episode is over, or has not begun; call reset first")
        if set(actions) != set(self.agents):
            raise ValueError(f"actions for {sorted(actions)}; allowed is one for each of {self.agents}")
        for agent in self.agents:
            self._actions[self._places[agent]] = as_action(actions[agent], f"action of {agent}")
        gain = self._team.step(self._actions)
        for place, way in enumerate(self._ways):
            if way[-1] != self._cell(place):
                way.append(self._cell(place))
        moved, reasons = self.agents, self._team.termination_reasons()
        reason = {agent: reasons[self._places[agent]] for agent in moved}
        self.agents = [agent for agent in moved if reason[agent] == "searching"]
        return (
            self._observations(moved),
            dict.fromkeys(moved, gain),
            {agent: reason[agent] in ("found", "crashed") for agent in moved},
            {agent: reason[agent] == "spent" for agent in moved},
            self._infos(moved),
        )

    def render(self) -> NDArray[np.uint8] | None:
        """The map as a picture, with what the first robot believes and the ways of all: see :meth:`SearchEnv.render`."""
        if self.render_mode is None:
            return None
        ways = [np.array(way, dtype=np.int64) for way in self._ways]
        return picture.draw(self.scenario, self._arrays["probability"][0], ways, self.objects)

    def close(self) -> None:
        """Nothing is to be closed."""

    @property
    def objects(self) -> NDArray[np.int64]:
        """Cells that hold an object: the truth, which no policy may see."""
        return self._team.objects()

    @property
    def digests(self) -> dict[str, str]:
        """Digest of what each robot believes, by its name, and of all that was seen, by ``"team"``."""
        own, team = self._team.digests()
        return dict(zip(self.possible_agents, own, strict=True)) | {"team": team}

    def _cell(self, place: int) -> int:
        row, column = self._arrays["position"][place]
        return int(row) * self.scenario.shape[1] + int(column)

    def _observations(self, agents: list[str]) -> dict[str, Observation]:
        observations = {}
        for agent in agents:
            place = self._places[agent]
            observation = {name: self._arrays[name][place].copy() for name in OBSERVED}
            observation["traversable"] = self._traversable.copy()
            observation["teammates"] = self._arrays["teammates"][place].copy()
            observation["action_mask"] = self._arrays["action_mask"][place].copy()
            observations[agent] = observation
        return observations

    def _infos(self, agents: list[str]) -> dict[str, dict[str, Any]]:
        f1, recall, ways, seconds = self._team.measures()
        reasons = self._team.termination_reasons()
        infos = {}
        for agent in agents:
            place = self._places[agent]
            infos[agent] = {
                "action_mask": self._arrays["action_mask"][place].copy(),
                "termination_reason": reasons[place],
                "seed": self._seed,
                "f1": f1,
                "recall": recall,
                "path_cells": ways[place],
                "time_seconds": seconds,
            }
        return infos


def parallel_env(
    scenario: Scenario | str | os.PathLike[str],
    *,
    robots: int | None = None,
    control: str = "step",
    reward: str = "entropy",
    masked_action: str = "error",
    crashes: Mapping[int, float] | None = None,
    render_mode: str | None = None,
) -> TeamEnv:
    """A team searches until all objects are found or budgets are spent: a PettingZoo ``ParallelEnv``.

    Agents are ``"robot_1"`` to ``"robot_N"``; ``robots`` replaces the scenario's number. Each robot believes what it has seen
    and heard: observations travel over the scenario's network, with its loss, delay and partitions, and what is lost is
    asked for again, by the robots' own protocol. The observation is that of :class:`dragnet.SearchEnv` with

    - ``teammates``: row and column where the robot last heard each of the team to be, its own among them, int32, shape
      ``(robots, 2)``; ``-1`` before;
    - ``action_mask``: 1 where an action can be taken, int8; it is in ``info`` too.

    In each step every robot makes one move: with ``control="step"`` to a neighbor, with ``"waypoint"`` one cell along the
    shortest path to the cell that the action names. A step lasts until the last of them has arrived. The reward is the
    team's, the same for all: what :class:`dragnet.SearchEnv` says, of all that the team has seen together.

    A robot leaves ``agents`` when its budget is spent (``truncated``), when all is found, or when it crashes
    (``terminated``); ``info["termination_reason"]`` says which. ``crashes`` names seconds of mission time by the robot's number.
    """
    if ParallelEnv is object:
        raise ImportError("dragnet.parallel_env needs pettingzoo: pip install 'dragnet[teams]'")
    chosen = as_scenario(scenario)
    if robots is not None:
        chosen = chosen.with_robots(robots)
    return TeamEnv(chosen, control, reward, masked_action, crashes or {}, render_mode)
