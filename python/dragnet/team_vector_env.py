"""Many teams' searches side by side, in one batch."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from . import _dragnet, picture
from .batch_env import BatchEnv
from .choices import Control, Frame, MaskedAction, ObservationKind, Reward, VectorRenderMode
from .observation import action_space, state_space
from .scenario import Scenario, as_scenario

#: By their numbers in arrays.
_REASONS = np.array(_dragnet.reasons())


class TeamVectorEnv(BatchEnv):
    """``num_envs`` searches of a team, those of :func:`dragnet.parallel_env`, stepped side by side in Rust.

    Everything of a robot has the axes *environments, robots* in front, robots in the order of :attr:`possible_agents`:
    observations (the parts of those of ``parallel_env``), actions, rewards, terminations, truncations, and
    ``info["action_mask"]``. ``robot_observation_space`` and ``robot_action_space`` are the spaces of one robot.

    Environment ``i`` goes through the very episodes that ``parallel_env`` would with its seed. A robot that leaves them there
    stays here, ``terminated`` or ``truncated`` until the episode is over: its actions have no effect, its reward is 0, and it
    observes what it still hears. ``info["active"]`` says which robots search. An environment without a robot that searches,
    ``(terminated | truncated).all(axis=1)``, begins anew with the next call of :meth:`step` (autoreset ``NEXT_STEP``), whatever
    its actions, with rewards 0.

    ``info`` has, of environments, ``seed``, ``f1``, ``recall`` and ``time_seconds``, and of robots ``action_mask``, ``active``,
    ``termination_reason`` and ``path_cells``. The last ones of an episode come with the step that ends it.

    Observations, ``info["action_mask"]`` and :meth:`state` are written into arrays that stay where they are: each call changes
    those of the call before. Copy what you keep, or ask for ``copy=True``.
    """

    def __init__(
        self,
        scenario: Scenario | str | os.PathLike[str],
        num_envs: int = 1,
        *,
        robots: int | None = None,
        control: Control = "step",
        reward: Reward = "entropy",
        masked_action: MaskedAction = "stay",
        observation: ObservationKind = "dict",
        frame: Frame = "map",
        crashes: Mapping[int, float] | None = None,
        render_mode: VectorRenderMode | None = None,
        copy: bool = False,
    ):
        chosen = as_scenario(scenario)
        if robots is not None:
            chosen = chosen.with_robots(robots)
        super().__init__(
            chosen,
            num_envs,
            (chosen.robots,),
            (control, reward, masked_action, observation, frame, dict(crashes or {})),
            control=control,
            observation=observation,
            frame=frame,
            render_mode=render_mode,
            copy=copy,
        )
        #: Names of the robots, in the order of their axis.
        self.possible_agents = [f"robot_{number}" for number in range(1, chosen.robots + 1)]
        #: The spaces of one robot.
        self.robot_observation_space = self._observer.space()
        self.robot_action_space = action_space(chosen, control)
        #: The space of one environment's part of :meth:`state`, and of all of it.
        self.single_state_space: spaces.Box = state_space(chosen)
        self.state_space = batch_space(self.single_state_space, self.num_envs)

    def state(self) -> NDArray[np.float32]:
        """What each team knows together, for a critic: float32, ``0..1``, shape ``(num_envs, 5 + robots, rows, columns)``.

        The planes are those of :meth:`dragnet.parallel_env`'s ``state``. An environment that is over has its last state.
        """
        self._check_open("state")
        self._native.state()
        state: NDArray[np.float32] = self._arrays["state"].reshape(self.state_space.shape)
        return state.copy() if self._copy else state

    def _more_infos(self) -> dict[str, Any]:
        arrays = self._arrays
        return {
            "active": ~(arrays["terminated"] | arrays["truncated"]),
            "termination_reason": _REASONS[arrays["reason"]],
        }

    def _new_native(self) -> _dragnet.TeamBatch:
        return _dragnet.TeamBatch(self.scenario.native, self.num_envs, *self._choices)

    def _native_copy(self) -> _dragnet.TeamBatch:
        # Robots and messages under way are not copied: the same actions lead to the same state.
        native = self._new_native()
        for place, history in enumerate(self._history()):
            if history is not None:
                native.replay(place, *history)
        return native

    def _picture(self, place: int) -> NDArray[np.uint8]:
        native: _dragnet.TeamBatch = self._native
        beliefs = [native.belief(place, robot) for robot in range(self.scenario.robots)]
        plans = self._ahead(beliefs, place)
        return picture.draw(
            self.scenario, beliefs[0]["probability"], native.tracks(place), native.objects(place), plans
        )
