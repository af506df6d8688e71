"""A team's search as a PettingZoo parallel environment."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from gymnasium import spaces
from gymnasium.utils import seeding
from numpy.typing import ArrayLike, NDArray

from . import _dragnet, picture
from .choices import (
    Control,
    Frame,
    MaskedAction,
    ObservationKind,
    RenderMode,
    Reward,
    as_action,
    as_seed,
    check_render_mode,
)
from .native import NativeEnv, shaped
from .observation import Arrays, Observer, action_space, state_space
from .plan import Plan, as_cells
from .scenario import Scenario, as_scenario

if TYPE_CHECKING:
    from pettingzoo import ParallelEnv  # type: ignore[import-untyped]
else:
    try:
        from pettingzoo import ParallelEnv
    except ImportError:
        ParallelEnv = object

_REASONS = _dragnet.reasons()


class TeamEnv(NativeEnv, ParallelEnv):  # type: ignore[misc]
    """The environment of :func:`parallel_env`."""

    metadata = {"name": "dragnet_search_v0", "render_modes": ["human", "rgb_array"], "render_fps": 10}

    def __init__(
        self,
        scenario: Scenario,
        control: Control,
        reward: Reward,
        masked_action: MaskedAction,
        observation: ObservationKind,
        frame: Frame,
        crashes: Mapping[int, float],
        render_mode: RenderMode | None,
    ):
        check_render_mode(render_mode, self.metadata["render_modes"])
        self.scenario = scenario
        self.render_mode = render_mode
        self._choices = (control, reward, masked_action, observation, frame, dict(crashes))
        native = self._new_native()
        self._observer = Observer(scenario, observation, frame, control, native.features())
        self._connect(native)
        self.possible_agents = [f"robot_{number}" for number in range(1, scenario.robots + 1)]
        self.agents: list[str] = []
        self._places = {agent: place for place, agent in enumerate(self.possible_agents)}
        self._actions = np.zeros(scenario.robots, dtype=np.int64)
        self._mask = np.ones(1, dtype=np.bool_)
        self._random: np.random.Generator | None = None
        self._seed = 0
        self._plans = [Plan() for _ in self.possible_agents]
        self._observation_space = self._observer.space()
        self._action_spaces = {agent: action_space(scenario, control) for agent in self.possible_agents}
        #: The space of :meth:`state`.
        self.state_space = state_space(scenario)
        self._open_window(scenario.name)

    def observation_space(self, agent: str) -> spaces.Space[Any]:
        """The space of a robot's observations: the same for all."""
        self._places[agent]
        return self._observation_space

    def action_space(self, agent: str) -> spaces.Discrete:
        """Cells to head for, or steps."""
        return self._action_spaces[agent]

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, dict[str, Any]]]:
        """Begins an episode: the one of a seed, or the next one. There are no options; one that is given has no effect, and is
        warned of: PettingZoo's tests of environments pass one.
        """
        self._check_open("reset")
        for name in options or {}:
            warnings.warn(f"option {name!r} has no effect; there are none", UserWarning, stacklevel=2)
        if seed is not None:
            self._random, _ = seeding.np_random(as_seed(seed))
            self._seed = as_seed(seed)
        else:
            if self._random is None:
                self._random, _ = seeding.np_random()
            self._seed = int(self._random.integers(2**63))
        self._native.reset(np.array([self._seed], dtype=np.uint64), self._mask)
        self.agents = list(self.possible_agents)
        self._plans = [Plan() for _ in self.possible_agents]
        self._show()
        return self._observations(self.agents), self._infos(self.agents)

    def step(
        self, actions: Mapping[str, int]
    ) -> tuple[dict[str, Any], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]]:
        """Every robot that is still in ``agents`` takes its action, all at the same time."""
        self._check_open("step")
        if not self.agents:
            raise RuntimeError("step without agents: the episode is over, or has not begun; call reset first")
        if set(actions) != set(self.agents):
            raise ValueError(f"actions for {sorted(actions)}; allowed is one for each of {self.agents}")
        for agent in self.agents:
            self._actions[self._places[agent]] = as_action(actions[agent], f"action of {agent}")
        self._native.step(self._actions)
        moved, arrays = self.agents, self._arrays
        places = [self._places[agent] for agent in moved]
        terminated = dict(zip(moved, arrays["terminated"][0, places].tolist(), strict=True))
        truncated = dict(zip(moved, arrays["truncated"][0, places].tolist(), strict=True))
        self.agents = [agent for agent in moved if not (terminated[agent] or truncated[agent])]
        if self.render_mode is not None:
            self._follow_plans()
            self._show()
        return (
            self._observations(moved),
            dict(zip(moved, arrays["reward"][0, places].tolist(), strict=True)),
            terminated,
            truncated,
            self._infos(moved),
        )

    def state(self) -> NDArray[np.float32]:
        """What all robots together know, for a critic of the team: float32, ``0..1``, shape ``(5 + robots, rows, columns)``.

        ``probability``, ``entropy``, ``observed``, ``traversable`` and ``searched`` of all that the team has seen, as
        observations have them, and a plane for each robot: 1 in its cell while it searches. It holds no truth.
        """
        self._check_open("state")
        self._native.state()
        state: NDArray[np.float32] = self._arrays["state"].reshape(self.state_space.shape)
        return state.copy()

    def belief(self, agent: str) -> Arrays:
        """What a robot believes, exactly: see :meth:`dragnet.SearchEnv.belief`."""
        return self._native.belief(0, self._places[agent])

    def action_masks(self) -> dict[str, NDArray[np.bool_]]:
        """Which actions each robot of ``agents`` can take, shape ``(actions,)`` each."""
        masks = self._arrays["action_mask"][0]
        return {agent: masks[self._places[agent]].astype(np.bool_) for agent in self.agents}

    def render(self) -> NDArray[np.uint8] | None:
        """The map as a picture, with what the first robot believes, and the paths and plans of all: see
        :meth:`SearchEnv.render`."""
        self._check_open("render")
        if self.render_mode != "rgb_array":
            self._show()
            return None
        return self._picture(0)

    def show_plan(self, agent: str, cells: ArrayLike) -> None:
        """Pictures show these cells as the planned path of a robot: see :meth:`SearchEnv.show_plan`."""
        self._check_open("show_plan")
        self._plans[self._places[agent]] = Plan(as_cells(cells, self.scenario))

    @property
    def features(self) -> list[str]:
        """Names of the features of cells, in the order of planes and of ``x``."""
        return list(self._observer.features)

    @property
    def objects(self) -> NDArray[np.int64]:
        """Cells that hold an object: the truth, which no policy may see."""
        return self._native.objects(0)

    @property
    def digests(self) -> dict[str, str]:
        """Digest of what each robot believes, by its name, and of all that was seen, by ``"team"``."""
        own, team = self._native.digests(0)
        return dict(zip(self.possible_agents, own, strict=True)) | {"team": team}

    def _follow_plans(self) -> None:
        is_waypoint = self._choices[0] == "waypoint"
        for agent, cell, plan in zip(self.possible_agents, self._native.cells(0), self._plans, strict=True):
            goal = int(self._actions[self._places[agent]]) if is_waypoint else None
            plan.take(goal, cell, agent not in self.agents)

    def _picture(self, place: int) -> NDArray[np.uint8]:
        beliefs = [self._native.belief(0, robot) for robot in range(self.scenario.robots)]
        plans = [
            plan.ahead(belief["distance"], self.scenario.connectivity)
            for plan, belief in zip(self._plans, beliefs, strict=True)
        ]
        return picture.draw(self.scenario, beliefs[0]["probability"], self._native.tracks(0), self.objects, plans)

    def _observations(self, agents: list[str]) -> dict[str, Any]:
        is_belief = self._observer.kind == "belief"
        places = {agent: self._places[agent] for agent in agents}
        return {
            agent: self._observer.take(self._views, self._native.belief(0, place) if is_belief else None, (0, place))
            for agent, place in places.items()
        }

    def _infos(self, agents: list[str]) -> dict[str, dict[str, Any]]:
        arrays = self._arrays
        infos = {}
        for agent in agents:
            place = self._places[agent]
            infos[agent] = {
                "action_mask": arrays["action_mask"][0, place].copy(),
                "termination_reason": _REASONS[arrays["reason"][0, place]],
                "seed": self._seed,
                "f1": float(arrays["f1"][0]),
                "recall": float(arrays["recall"][0]),
                "path_cells": float(arrays["path_cells"][0, place]),
                "time_seconds": float(arrays["time_seconds"][0]),
            }
        return infos

    def _new_native(self) -> _dragnet.TeamBatch:
        return _dragnet.TeamBatch(self.scenario.native, 1, *self._choices)

    def _native_copy(self) -> _dragnet.TeamBatch:
        # Robots and messages under way are not copied: the same actions lead to the same state.
        native, history = self._new_native(), self._history()
        if history is not None:
            native.replay(0, *history)
        return native

    def _connect(self, native: _dragnet.TeamBatch) -> None:
        self._native = native
        self._arrays = shaped(native.arrays(), (1, self.scenario.robots))
        self._views = self._observer.views(self._arrays)

    def _history(self) -> tuple[int, NDArray[np.int64]] | None:
        return self._native.history(0)

    def _replay(self, history: tuple[int, NDArray[np.int64]] | None) -> None:
        if history is not None:
            self._native.replay(0, *history)


def parallel_env(
    scenario: Scenario | str | os.PathLike[str],
    *,
    robots: int | None = None,
    control: Control = "step",
    reward: Reward = "entropy",
    masked_action: MaskedAction = "stay",
    observation: ObservationKind = "dict",
    frame: Frame = "map",
    crashes: Mapping[int, float] | None = None,
    render_mode: RenderMode | None = None,
) -> TeamEnv:
    """A team searches until all objects are found or budgets are spent: a PettingZoo ``ParallelEnv``.

    Agents are ``"robot_1"`` to ``"robot_N"``; ``robots`` replaces the scenario's number. Each robot believes what it has seen
    and heard: observations travel over the scenario's network, with its loss, delay and partitions, and what is lost is
    asked for again, by the robots' own protocol. An observation is that of :class:`dragnet.SearchEnv`, with one more feature of
    cells, ``teammates``: 1 where the robot last heard another of the team to be. Planes come with their mask, in a dict of
    ``observation`` and ``action_mask``, as PettingZoo's own environments have them.

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
    return TeamEnv(chosen, control, reward, masked_action, observation, frame, crashes or {}, render_mode)
