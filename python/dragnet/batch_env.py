"""What vector environments share: many searches in one native part, their seeds, and arrays that stay where they are."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import ArrayLike, NDArray

from .choices import (
    Control,
    Frame,
    ObservationKind,
    VectorRenderMode,
    as_count,
    as_seed,
    check_options,
    check_render_mode,
)
from .native import NativeEnv, shaped
from .observation import Arrays, Observer, action_space
from .plan import Plan
from .scenario import Scenario


class BatchEnv(NativeEnv, VectorEnv[Any, NDArray[np.int64], NDArray[Any]]):  # type: ignore[misc]
    """``num_envs`` searches of one scenario, stepped side by side in Rust, the interpreter lock released."""

    metadata = {"render_modes": ["rgb_array"], "render_fps": 10, "autoreset_mode": AutoresetMode.NEXT_STEP}

    #: What ``info`` tells beside masks and seeds, by the names of arrays.
    _MEASURES = ("f1", "recall", "path_cells", "time_seconds")

    def __init__(
        self,
        scenario: Scenario,
        num_envs: int,
        lead: tuple[int, ...],
        choices: tuple[Any, ...],
        *,
        control: Control,
        observation: ObservationKind,
        frame: Frame,
        render_mode: VectorRenderMode | None,
        copy: bool,
    ):
        super().__init__()
        check_render_mode(render_mode, self.metadata["render_modes"])
        self.scenario = scenario
        self.num_envs = as_count(num_envs, "num_envs")
        self.render_mode = render_mode
        # The axes of robots: the searches, and the robots of each if it is of a team.
        self._lead = (self.num_envs, *lead)
        self._choices = choices
        native = self._new_native()
        self._observer = Observer(scenario, observation, frame, control, native.features())
        self._connect(native)
        self.single_observation_space = self._observer.space()
        self.single_action_space = action_space(scenario, control)
        for count in lead:
            self.single_observation_space = batch_space(self.single_observation_space, count)
            self.single_action_space = batch_space(self.single_action_space, count)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self._copy = copy
        # What pictures show as goals: waypoints of the last actions, -1 for none, of one robot after the other.
        self._goals = np.full(math.prod(self._lead), -1, dtype=np.int64)
        self._shows_goals = control == "waypoint" and render_mode is not None
        self._all = np.ones(self.num_envs, dtype=np.bool_)
        self._seeds = np.zeros(self.num_envs, dtype=np.uint64)
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
        seeds = self._checked_seeds(seed)
        if not self._randoms:
            self._randoms = [seeding.np_random()[0] for _ in range(self.num_envs)]
        for place in np.flatnonzero(mask):
            given = seeds[place]
            if given is not None:
                self._seeds[place] = given
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
        self._goals.reshape(self._lead)[mask] = -1
        return self._told(), self._infos(mask)

    def _checked_seeds(self, seed: int | Sequence[int | None] | None) -> list[int | None]:
        """A seed for each environment, or none: all are checked before anything changes."""
        if seed is None:
            return [None] * self.num_envs
        if isinstance(seed, (int, np.integer)):
            first = as_seed(seed)
            return [as_seed(first + place) for place in range(self.num_envs)]
        if not isinstance(seed, (Sequence, np.ndarray)) or isinstance(seed, str):
            raise TypeError(
                f"seed {seed!r} of type {type(seed).__name__}; allowed is an integer, or a list of {self.num_envs}"
            )
        if len(seed) != self.num_envs:
            raise ValueError(f"{len(seed)} seeds; allowed is {self.num_envs}, one each")
        return [None if given is None else as_seed(given) for given in seed]

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
        """Takes an action of each robot: integers of the shape of ``action_space``."""
        self._check_open("step")
        checked = self._checked_actions(actions)
        if self._next_seeds is None:
            raise RuntimeError("step before the first reset; call reset first")
        arrays = self._arrays
        begun = np.flatnonzero(arrays["over"])
        goals = self._of_active(checked) if self._shows_goals else self._goals
        self._native.step(checked, self._next_seeds)
        if self._shows_goals:
            self._goals = self._of_active(goals)
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

    def _checked_actions(self, actions: ArrayLike) -> NDArray[np.int64]:
        """Actions as the native part takes them: one after the other."""
        allowed = f"allowed is {self._lead}" + (", environments and robots" if len(self._lead) > 1 else "")
        try:
            array = np.asarray(actions)
        except ValueError:
            raise ValueError(f"actions of rows of different lengths; {allowed}") from None
        if array.dtype.kind not in "iu":
            raise TypeError(f"actions of dtype {array.dtype}; allowed are integers")
        if array.shape != self._lead:
            raise ValueError(f"actions of shape {array.shape}; {allowed}")
        return array.astype(np.int64, copy=False).ravel()

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """A picture of each environment, as the environment alone draws it."""
        self._check_open("render")
        if self.render_mode is None:
            return None
        return tuple(self._picture(place) for place in range(self.num_envs))

    def action_masks(self) -> NDArray[np.bool_]:
        """Which actions can be taken: the axes of robots, then the actions."""
        self._check_open("action_masks")
        return self._arrays["action_mask"].astype(np.bool_)

    def belief(self) -> Arrays:
        """What each robot believes, exactly: :meth:`dragnet.SearchEnv.belief`, with the axes of robots in front."""
        self._check_open("belief")
        beliefs = [self._native.belief(*place) for place in np.ndindex(*self._lead)]
        return {
            name: np.stack([belief[name] for belief in beliefs]).reshape(*self._lead, *part.shape)
            for name, part in beliefs[0].items()
        }

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

    def _connect(self, native: Any) -> None:
        self._native = native
        self._arrays = shaped(native.arrays(), self._lead)
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
        for name in self._MEASURES:
            infos[name] = self._arrays[name].copy()
        infos |= self._more_infos()
        for name in list(infos):
            infos["_" + name] = self._all if told is None else told
        return infos

    def _more_infos(self) -> dict[str, Any]:
        """What else is told of the searches."""
        return {}

    def _of_active(self, goals: NDArray[np.int64]) -> NDArray[np.int64]:
        """Goals without those of robots that are out of their episode: these go nowhere."""
        is_out = self._arrays["terminated"] | self._arrays["truncated"]
        return np.where(is_out.ravel(), -1, goals)

    def _ahead(self, beliefs: list[Arrays], place: int) -> list[NDArray[np.int64]]:
        """What the robots of an environment are still to enter on the way to their goals."""
        goals = self._goals.reshape(self.num_envs, -1)[place]
        return [
            Plan(goal=None if goal < 0 else int(goal)).ahead(belief["distance"], self.scenario.connectivity)
            for goal, belief in zip(goals, beliefs, strict=True)
        ]
