"""Many searches side by side as a Gymnasium vector environment."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import ArrayLike, NDArray

from . import _dragnet, picture
from .choices import (
    Control,
    End,
    Frame,
    MaskedAction,
    ObservationKind,
    RenderMode,
    Reward,
    as_seed,
    check_options,
    check_render_mode,
)
from .native import NativeEnv
from .observation import Arrays, Observer, action_space
from .scenario import Scenario, as_scenario

_MEASURES = ("f1", "recall", "path_cells", "time_seconds")


class SearchVectorEnv(NativeEnv, VectorEnv[Any, NDArray[np.int64], NDArray[Any]]):  # type: ignore[misc]
    """``num_envs`` searches of :class:`dragnet.SearchEnv`, stepped side by side in Rust, the interpreter lock released.

    Environment ``i`` goes through the very episodes that ``SearchEnv`` would with its seed. One that is over begins anew
    with the next call of :meth:`step` (autoreset ``NEXT_STEP``), whatever its action, with reward 0.

    Observations and ``info["action_mask"]`` are written into arrays that stay where they are: each call changes those of the
    call before. Copy what you keep, or ask for ``copy=True``.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 10, "autoreset_mode": AutoresetMode.NEXT_STEP}

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
        render_mode: RenderMode | None = None,
        copy: bool = False,
    ):
        super().__init__()
        check_render_mode(render_mode)
        self.scenario = as_scenario(scenario).with_robots(1)
        self.num_envs = num_envs
        self.render_mode = render_mode
        self._choices = (control, reward, end, masked_action, observation, frame)
        native = self._new_native()
        self._observer = Observer(self.scenario, observation, frame, control, native.features())
        self._connect(native)
        self.single_observation_space = self._observer.space()
        self.single_action_space = action_space(self.scenario, control)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._copy = copy
        self._all = np.ones(num_envs, dtype=np.bool_)
        self._seeds = np.zeros(num_envs, dtype=np.uint64)
        # Those of the episodes to come, if the first ones have begun.
        self._next_seeds: NDArray[np.uint64] | None = None
        self._randoms: list[np.random.Generator] = []

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begins all episodes: environment ``i`` that of ``seed + i``, or of ``seed[i]``, or its next one.

        ``options={"reset_mask": mask}`` begins those alone where ``mask``, booleans of shape ``(num_envs,)``, is true; the
        others go on as if nothing had been called. There are no other options.
        """
        self._check_open("reset")
        mask = self._reset_mask(options)
        if seed is None:
            seeds: list[int | None] = [None] * self.num_envs
        elif isinstance(seed, (int, np.integer)):
            seeds = [int(seed) + place for place in range(self.num_envs)]
        else:
            seeds = list(seed)
        if len(seeds) != self.num_envs:
            raise ValueError(f"{len(seeds)} seeds; allowed is {self.num_envs}, one each")
        if not self._randoms:
            self._randoms = [seeding.np_random()[0] for _ in range(self.num_envs)]
        for place in np.flatnonzero(mask):
            given = seeds[place]
            if given is not None:
                self._seeds[place] = as_seed(given)
                self._randoms[place] = seeding.np_random(given)[0]
            elif self._next_seeds is None:
                self._seeds[place] = self._draw(place)
            else:
                self._seeds[place] = self._next_seeds[place]
        if self._next_seeds is None:
            self._next_seeds = np.zeros(self.num_envs, dtype=np.uint64)
        for place in np.flatnonzero(mask):
            self._next_seeds[place] = self._draw(place)
        self._native.reset(self._seeds, mask)
        return self._told(), self._infos(mask)

    def _reset_mask(self, options: dict[str, Any] | None) -> NDArray[np.bool_]:
        check_options(options, ["reset_mask"])
        if not options:
            return self._all
        mask = options["reset_mask"]
        if not isinstance(mask, np.ndarray) or mask.dtype != np.bool_ or mask.shape != (self.num_envs,):
            found = f"of {mask.dtype} {mask.shape}" if isinstance(mask, np.ndarray) else f"{mask!r}"
            raise ValueError(f"reset_mask {found}; allowed is an array of booleans of shape ({self.num_envs},)")
        if not mask.any():
            raise ValueError("reset_mask without a true entry; allowed is at least one")
        if self._next_seeds is None and not mask.all():
            raise RuntimeError("reset of some environments before the first reset; reset all of them first")
        return mask.copy()

    def step(
        self, actions: ArrayLike
    ) -> tuple[Any, NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """Takes one action in each environment: integers of shape ``(num_envs,)``."""
        self._check_open("step")
        actions = np.asarray(actions)
        if actions.dtype.kind not in "iu":
            raise TypeError(f"actions of dtype {actions.dtype}; allowed are integers")
        if actions.shape != (self.num_envs,):
            raise ValueError(f"actions of shape {actions.shape}; allowed is ({self.num_envs},)")
        if self._next_seeds is None:
            raise RuntimeError("step before the first reset; call reset first")
        arrays = self._arrays
        begun = np.flatnonzero(arrays["terminated"] | arrays["truncated"])
        self._native.step(actions.astype(np.int64, copy=False), self._next_seeds)
        for place in begun:
            self._seeds[place] = self._next_seeds[place]
            self._next_seeds[place] = self._draw(place)
        return (
            self._told(),
            arrays["reward"].copy(),
            arrays["terminated"].copy(),
            arrays["truncated"].copy(),
            self._infos(),
        )

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """A picture of each environment, as :meth:`dragnet.SearchEnv.render` draws it."""
        self._check_open("render")
        if self.render_mode is None:
            return None
        return tuple(
            picture.draw(
                self.scenario,
                self._native.belief(place)["probability"],
                [self._native.track(place)],
                self._native.objects(place),
            )
            for place in range(self.num_envs)
        )

    def action_masks(self) -> NDArray[np.bool_]:
        """Which actions can be taken in each environment, shape ``(num_envs, actions)``."""
        return self._arrays["action_mask"].astype(np.bool_)

    def belief(self) -> Arrays:
        """What each robot believes, exactly: :meth:`dragnet.SearchEnv.belief`, with the environments as the first axis."""
        beliefs = [self._native.belief(place) for place in range(self.num_envs)]
        return {name: np.stack([belief[name] for belief in beliefs]) for name in beliefs[0]}

    @property
    def features(self) -> list[str]:
        """Names of the features of cells, in the order of planes and of ``x``."""
        return list(self._observer.features)

    def _draw(self, place: int | np.integer[Any]) -> int:
        return int(self._randoms[place].integers(2**63))

    def _told(self) -> Any:
        views = {name: view.copy() for name, view in self._views.items()} if self._copy else dict(self._views)
        if self._observer.kind == "belief":
            return self.belief() | views
        return views["observation"] if self._observer.is_array else views

    def _new_native(self) -> _dragnet.Batch:
        return _dragnet.Batch(self.scenario.native, self.num_envs, *self._choices)

    def _native_copy(self) -> _dragnet.Batch:
        return self._native.clone()

    def _connect(self, native: _dragnet.Batch) -> None:
        self._native = native
        self._arrays = native.arrays()
        self._views = self._observer.views(self._arrays)

    def _history(self) -> list[tuple[int, NDArray[np.int64]] | None]:
        return [self._native.history(place) for place in range(self.num_envs)]

    def _replay(self, history: list[tuple[int, NDArray[np.int64]] | None]) -> None:
        for place, of_lane in enumerate(history):
            if of_lane is not None:
                self._native.replay(place, *of_lane)

    def _infos(self, told: NDArray[np.bool_] | None = None) -> dict[str, Any]:
        mask = self._arrays["action_mask"]
        infos: dict[str, Any] = {"action_mask": mask.copy() if self._copy else mask, "seed": self._seeds.copy()}
        for name in _MEASURES:
            infos[name] = self._arrays[name].copy()
        for name in list(infos):
            infos["_" + name] = self._all if told is None else told
        return infos
