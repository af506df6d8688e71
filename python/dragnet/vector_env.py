"""Many searches side by side as a Gymnasium vector environment."""

from __future__ import annotations

import os

import numpy as np
from numpy.typing import NDArray

from . import _dragnet, picture
from .batch_env import BatchEnv
from .choices import Control, End, Frame, MaskedAction, ObservationKind, Reward, VectorRenderMode
from .scenario import Scenario, as_scenario


class SearchVectorEnv(BatchEnv):
    """``num_envs`` searches of :class:`dragnet.SearchEnv`, stepped side by side in Rust, the interpreter lock released.

    Environment ``i`` goes through the very episodes that ``SearchEnv`` would with its seed. One that is over begins anew
    with the next call of :meth:`step` (autoreset ``NEXT_STEP``), whatever its action, with reward 0.

    Observations and ``info["action_mask"]`` are written into arrays that stay where they are: each call changes those of the
    call before. Copy what you keep, or ask for ``copy=True``.
    """

    def __init__(
        self,
        scenario: Scenario | str | os.PathLike[str],
        num_envs: int = 1,
        *,
        control: Control = "waypoint",
        reward: Reward = "entropy",
        end: End = "all_found",
        masked_action: MaskedAction = "stay",
        observation: ObservationKind = "dict",
        frame: Frame = "map",
        render_mode: VectorRenderMode | None = None,
        copy: bool = False,
    ):
        super().__init__(
            as_scenario(scenario).with_robots(1),
            num_envs,
            (),
            (control, reward, end, masked_action, observation, frame),
            control=control,
            observation=observation,
            frame=frame,
            render_mode=render_mode,
            copy=copy,
        )

    def _new_native(self) -> _dragnet.Batch:
        return _dragnet.Batch(self.scenario.native, self.num_envs, *self._choices)

    def _native_copy(self) -> _dragnet.Batch:
        native: _dragnet.Batch = self._native.clone()
        return native

    def _picture(self, place: int) -> NDArray[np.uint8]:
        native: _dragnet.Batch = self._native
        belief = native.belief(place)
        plans = self._ahead([belief], place)
        return picture.draw(self.scenario, belief["probability"], [native.track(place)], native.objects(place), plans)
