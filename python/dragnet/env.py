"""One robot's search as a Gymnasium environment."""

from __future__ import annotations

import os
from typing import Any

import gymnasium as gym
import numpy as np
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
    as_action,
    as_seed,
    check_options,
    check_render_mode,
)
from .native import NativeEnv
from .observation import Arrays, Observer, action_space
from .plan import Plan, as_cells
from .scenario import Scenario, as_scenario


class SearchEnv(NativeEnv, gym.Env[Any, Any]):
    """One robot searches until it has found all objects or its budget is spent.

    World, noise, motion and measures are those of the simulator: with the seed ``s`` of :meth:`reset` an episode has the
    objects, the start and the noise of ``dragnet run --robots 1 --seed s``. Without a seed it is drawn from ``np_random``;
    ``info["seed"]`` names it.

    **Action.** ``control="waypoint"``: a cell; the robot goes there on the shortest path and looks around in every cell that
    it enters (or as far as the scenario's ``replan_after_cells`` allows). ``control="step"``: a step to a neighbor, by its place
    in ``dragnet.OFFSETS[scenario.connectivity]``. ``info["action_mask"]`` (int8) and :meth:`action_masks` (bool) say which
    can be taken. With one that cannot the robot stays, without a look, at the cost of one cell of each budget; with
    ``masked_action="error"`` it raises ``ValueError``.

    **Observation.** All numbers are finite, float32, and from 0 to 1. *Cells* have the shape ``(rows, columns)``.

    - ``observation="dict"``: of cells ``probability`` of an object, its ``entropy`` (bits), ``observed`` (how precisely it was
      read: 0 not at all, 1/2 once from the sensor's radius), ``traversable``, ``searched``, ``distance`` (``d / (d + h)`` of the
      shortest path of ``d`` cells, ``h`` half of rows and columns together; 1 out of reach); of the robot ``position``, shape
      ``(2,)``, row and column as shares of the last ones, and ``budget``, shape ``(1,)``, the share that is left; ``action_mask``
      (int8).
    - ``"planes"``: one array, shape ``(8, rows, columns)``, in the order of :attr:`features`: those of cells, then ``robot`` (1 in
      its cell) and ``budget`` (the same in every cell).
    - ``"graph"``: ``x``, shape ``(cells, 10)``, the same features and ``row`` and ``column``, as shares of the longer side;
      ``edge_index`` (int64, ``(2, edges)``), the moves between cells; ``edge_attr``, ``(edges, 1)``, their lengths in cells,
      1 or the root of 2; ``action_mask``. ``x``, ``edge_index`` and ``edge_attr`` are what ``torch_geometric.data.Data`` takes.
    - ``"belief"``: what :meth:`belief` returns, with ``action_mask``: exact, float64, and infinite where it is.

    With ``frame="robot"`` nothing is observed of the place on the map: cells have the shape ``(2 rows - 1, 2 columns - 1)`` with
    the robot in the middle, ``position`` is left out, and ``row`` and ``column`` are those from the robot, -1 to 1.

    **Reward.** ``"entropy"``: entropy of the belief removed, nats; ``"found"``: objects newly found (below 0 if some are no
    longer); ``"f1"``: gain of F1, ``-1..1``.

    **End.** ``terminated`` when every object is found; with ``end="resting"``, as the robots of the field, which cannot know
    that, when so few are expected to be left that the scenario calls it cleared. ``truncated`` when the budget is spent.

    ``info`` also has ``f1``, ``recall``, ``path_cells`` (way covered) and ``time_seconds``.
    """

    metadata = {"render_modes": ["human", "rgb_array"], "render_fps": 10}

    def __init__(
        self,
        scenario: Scenario | str | os.PathLike[str],
        *,
        control: Control = "waypoint",
        reward: Reward = "entropy",
        end: End = "all_found",
        masked_action: MaskedAction = "stay",
        observation: ObservationKind = "dict",
        frame: Frame = "map",
        render_mode: RenderMode | None = None,
    ):
        check_render_mode(render_mode, self.metadata["render_modes"])
        self.scenario = as_scenario(scenario).with_robots(1)
        self.render_mode = render_mode
        self._choices = (control, reward, end, masked_action, observation, frame)
        native = self._new_native()
        self._observer = Observer(self.scenario, observation, frame, control, native.features())
        self._connect(native)
        self._actions = np.zeros(1, dtype=np.int64)
        self._mask = np.ones(1, dtype=np.bool_)
        self._seed = 0
        self._plan = Plan()
        self.observation_space = self._observer.space()
        self.action_space = action_space(self.scenario, control)
        self._open_window(self.scenario.name)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begins an episode: the one of a seed, or the next one. There are no options."""
        self._check_open("reset")
        check_options(options, [])
        super().reset(seed=seed)
        self._seed = int(self.np_random.integers(2**63)) if seed is None else as_seed(seed)
        self._native.reset(np.array([self._seed], dtype=np.uint64), self._mask)
        self._plan = Plan()
        self._show()
        return self._observation(), self._info()

    def step(self, action: int) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Takes an action. An episode that was over as it began is over after the first one, which then does nothing."""
        self._check_open("step")
        self._actions[0] = as_action(action)
        self._native.step(self._actions)
        arrays = self._arrays
        if self.render_mode is not None:
            is_over = bool(arrays["terminated"][0] or arrays["truncated"][0])
            self._plan.take(self._goal(), int(self.path[-1]), is_over)
            self._show()
        return (
            self._observation(),
            float(arrays["reward"][0]),
            bool(arrays["terminated"][0]),
            bool(arrays["truncated"][0]),
            self._info(),
        )

    def render(self) -> NDArray[np.uint8] | None:
        """The map as a picture, north up, uint8, shape ``(height, width, 3)``; nothing without a ``render_mode``.

        Dark cells cannot be entered, red is belief; a blue line is the path, a ring an object (green once it is found), a blue
        square the robot, dots the planned path and a cross its goal; the legend below says so. A goal is the last waypoint,
        or the end of what :meth:`show_plan` was given. With ``render_mode="human"`` the picture is in a window, which every
        reset and step draws.
        """
        self._check_open("render")
        if self.render_mode is None:
            gym.logger.warn("no render_mode was given to SearchEnv")
        if self.render_mode != "rgb_array":
            self._show()
            return None
        return self._picture(0)

    def show_plan(self, cells: ArrayLike) -> None:
        """Pictures show these cells, in the order in which they are to be entered, as the planned path: what a policy plans,
        ``decision.path``, and only a waypoint or a step tells of. Until the robot leaves it, or the episode ends.
        """
        self._check_open("show_plan")
        self._plan = Plan(as_cells(cells, self.scenario))

    def action_masks(self) -> NDArray[np.bool_]:
        """Which actions can be taken, shape ``(actions,)``: the name under which sb3-contrib looks for it."""
        masks: NDArray[np.bool_] = self._arrays["action_mask"][0].astype(np.bool_)
        return masks

    def belief(self) -> Arrays:
        """What the robot believes, exactly: what :class:`dragnet.Policy` decides from, and no input for a network.

        Arrays of their own, shape ``(rows, columns)`` but for ``position``:

        - ``log_odds``: ``ln(p / (1 - p))`` of an object, nats, float64; ``-inf`` where nothing is searched;
        - ``probability``: ``p``, float32, ``0..1``;
        - ``precision`` and ``weighted_sum``: sums of ``1/v`` and ``y/v`` over the readings ``y`` of variance ``v``, float64;
        - ``distance``: length of the shortest path from the robot, cells, float32; ``inf`` out of reach;
        - ``traversable``: 1 where a robot can be, int8;
        - ``position``: row and column of the robot, int64, shape ``(2,)``.
        """
        return self._native.belief(0)

    @property
    def features(self) -> list[str]:
        """Names of the features of cells, in the order of planes and of ``x``."""
        return list(self._observer.features)

    @property
    def path(self) -> NDArray[np.int64]:
        """Every cell that the robot stood in, in order, from where it started."""
        return self._native.track(0)

    @property
    def objects(self) -> NDArray[np.int64]:
        """Cells that hold an object: the truth, which no policy may see."""
        return self._native.objects(0)

    @property
    def digest(self) -> str:
        """Digest of all evidence, 32 hexadecimal digits: equal beliefs have equal ones, on every machine."""
        return self._native.digest(0)

    @property
    def termination_reason(self) -> str | None:
        """Why the episode is over: ``"found"``, ``"cleared"`` or ``"spent"``; ``None`` if it is not."""
        return self._native.termination_reason(0)

    def _goal(self) -> int | None:
        return int(self._actions[0]) if self._choices[0] == "waypoint" else None

    def _picture(self, place: int) -> NDArray[np.uint8]:
        belief = self.belief()
        plan = self._plan.ahead(belief["distance"], self.scenario.connectivity)
        return picture.draw(self.scenario, belief["probability"], [self.path], self.objects, [plan])

    def _observation(self) -> Any:
        belief = self.belief() if self._observer.kind == "belief" else None
        return self._observer.take(self._views, belief, 0)

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

    def _new_native(self) -> _dragnet.Batch:
        return _dragnet.Batch(self.scenario.native, 1, *self._choices)

    def _native_copy(self) -> _dragnet.Batch:
        return self._native.clone()

    def _connect(self, native: _dragnet.Batch) -> None:
        self._native = native
        self._arrays = native.arrays()
        self._views = self._observer.views(self._arrays)

    def _history(self) -> tuple[int, NDArray[np.int64]] | None:
        return self._native.history(0)

    def _replay(self, history: tuple[int, NDArray[np.int64]] | None) -> None:
        if history is not None:
            self._native.replay(0, *history)
