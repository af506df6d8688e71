"""One robot's search as a Gymnasium environment."""

from __future__ import annotations

import os
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from . import _dragnet, picture
from .scenario import Scenario, as_scenario
from .spaces import OBSERVED, action_space, as_action, as_seed, check_options, observation_spaces

Observation = dict[str, NDArray[Any]]


class SearchEnv(gym.Env[Any, Any]):
    """One robot searches until it has found all objects or its budget is spent.

    World, noise, motion and measures are those of the simulator: with the seed ``s`` of :meth:`reset` an episode has the
    objects, the start and the noise of ``dragnet run --robots 1 --seed s``. Without a seed it is drawn from ``np_random``;
    ``info["seed"]`` names it.

    **Action.** ``control="waypoint"``: a cell; the robot goes there on the shortest path and looks around in every cell that
    it enters (or as far as the scenario's ``replan_after_cells`` allows). ``control="step"``: a step to a neighbor, by its place
    in ``dragnet.OFFSETS[scenario.connectivity]``. ``info["action_mask"]`` (int8) is 1 where an action can be taken. One that cannot
    raises ``ValueError``; with ``masked_action="stay"`` the robot stays instead, without a look, at the cost of one cell of
    each budget.

    **Observation.** A dict; cells have the shape ``(rows, columns)``:

    - ``log_odds``: ``ln(p / (1 - p))`` of an object, nats, float64; ``-inf`` where nothing is searched;
    - ``probability``: ``p``, float32, ``0..1``;
    - ``precision`` and ``weighted_sum``: sums of ``1/v`` and ``y/v`` over the readings ``y`` of variance ``v``, float64;
    - ``distance``: length of the shortest path from the robot, cells, float32; ``inf`` out of reach;
    - ``position``: row and column of the robot, int32, shape ``(2,)``;
    - ``traversable``: 1 where a robot can be, int8.

    **Reward.** ``"entropy"``: entropy of the belief removed, nats; ``"found"``: objects newly found (below 0 if some are no
    longer); ``"f1"``: gain of F1, ``-1..1``.

    **End.** ``terminated`` when every object is found; with ``end="resting"``, as the robots of the field, which cannot know
    that, when so few are expected to be left that the scenario calls it cleared. ``truncated`` when the budget is spent.

    ``info`` also has ``f1``, ``recall``, ``path_cells`` (way covered) and ``time_seconds``.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 10}

    def __init__(
        self,
        scenario: Scenario | str | os.PathLike[str],
        *,
        control: str = "waypoint",
        reward: str = "entropy",
        end: str = "all_found",
        masked_action: str = "error",
        render_mode: str | None = None,
    ):
        picture.check_mode(render_mode)
        self.scenario = as_scenario(scenario).with_robots(1)
        self.render_mode = render_mode
        self._batch = _dragnet.Batch(self.scenario.native, 1, control, reward, end, masked_action)
        self._arrays = self._batch.arrays()
        self._actions = np.zeros(1, dtype=np.int64)
        self._mask = np.ones(1, dtype=np.bool_)
        self._traversable = self.scenario.traversable.astype(np.int8)
        self._observed = {name: self._arrays[name][0] for name in OBSERVED}
        self._seed = 0
        self.observation_space = gym.spaces.Dict(observation_spaces(self.scenario))
        self.action_space = action_space(self.scenario, control)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begins an episode: the one of a seed, or the next one. There are no options."""
        check_options(options, [])
        super().reset(seed=seed)
        self._seed = int(self.np_random.integers(2**63)) if seed is None else as_seed(seed)
        self._batch.reset(np.array([self._seed], dtype=np.uint64), self._mask)
        return self._observation(), self._info()

    def step(self, action: int) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Takes an action. An episode that was over as it began is over after the first one, which then does nothing."""
        self._actions[0] = as_action(action)
        self._batch.step(self._actions)
        arrays = self._arrays
        return (
            self._observation(),
            float(arrays["reward"][0]),
            bool(arrays["terminated"][0]),
            bool(arrays["truncated"][0]),
            self._info(),
        )

    def render(self) -> NDArray[np.uint8] | None:
        """The map as a picture, north up, uint8, shape ``(height, width, 3)``; nothing without a ``render_mode``.

        Dark cells cannot be entered, red is belief; a blue line is the way, a ring an object (green once it is found), a blue
        square the robot.
        """
        if self.render_mode is None:
            gym.logger.warn("no render_mode was given to SearchEnv")
            return None
        return picture.draw(
            self.scenario,
            self._arrays["probability"][0],
            [self.path],
            self.objects,
        )

    @property
    def path(self) -> NDArray[np.int64]:
        """Every cell that the robot stood in, in order, from where it started."""
        return self._batch.track(0)

    @property
    def objects(self) -> NDArray[np.int64]:
        """Cells that hold an object: the truth, which no policy may see."""
        return self._batch.objects(0)

    @property
    def digest(self) -> str:
        """Digest of all evidence, 32 hexadecimal digits: equal beliefs have equal ones, on every machine."""
        return self._batch.digest(0)

    @property
    def termination_reason(self) -> str | None:
        """Why the episode is over: ``"found"``, ``"cleared"`` or ``"spent"``; ``None`` if it is not."""
        return self._batch.termination_reason(0)

    def _observation(self) -> Observation:
        observation = {name: array.copy() for name, array in self._observed.items()}
        observation["traversable"] = self._traversable.copy()
        return observation

    def _info(self) -> dict[str, Any]:
        arrays = self._arrays
        return {
            "action_mask": arrays["action_mask"][0].copy(),
            "seed": self._seed,
            "f1": float(arrays["f1"][0]),
            "recall": float(arrays["recall"][0]),
            "path_cells": float(arrays["path_cells"][0]),
            "time_seconds": float(arrays["time_seconds"][0]),
        }
