"""Pictures of a search, in plain NumPy."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .legend import Entry, legend
from .scenario import Scenario

#: Edge of a cell, pixels.
SCALE = 12

Image = NDArray[np.uint8]

_OPEN = np.array([255, 255, 255], dtype=np.float64)
_NOT_SEARCHED = np.array([225, 225, 225], dtype=np.float64)
_BLOCKED = np.array([60, 60, 60], dtype=np.float64)
_BELIEF = np.array([214, 40, 40], dtype=np.float64)
#: Of the paths of robots, in their order; the sixth is as the first.
PATH_COLORS = np.array([[31, 119, 180], [255, 127, 14], [148, 103, 189], [140, 86, 75], [23, 190, 207]], dtype=np.uint8)
_OBJECT = np.array([0, 0, 0], dtype=np.uint8)
_FOUND = np.array([44, 160, 44], dtype=np.uint8)


def draw(
    scenario: Scenario,
    probability: NDArray[np.float32],
    paths: Sequence[NDArray[np.int64]],
    objects: NDArray[np.int64],
    plans: Sequence[NDArray[np.int64]] = (),
) -> Image:
    """Map, belief, paths (each ends in its robot's cell), plans (cells still to be entered, the goal last) and objects, with a
    legend below; north up, shape ``(height, width, 3)``."""
    columns = scenario.shape[1]
    ground = np.where(scenario.searched[..., None], _OPEN, _NOT_SEARCHED)
    ground = np.where(scenario.traversable[..., None], ground, _BLOCKED)
    share = np.sqrt(probability.astype(np.float64))[..., None]
    cells = (ground * (1.0 - share) + _BELIEF * share).astype(np.uint8)
    image = np.repeat(np.repeat(cells, SCALE, axis=0), SCALE, axis=1)
    for place, plan in enumerate(plans):
        _draw_plan(image, np.concatenate([paths[place][-1:], plan]), columns, _color(place))
    for place, path in enumerate(paths):
        _draw_path(image, path, columns, _color(place))
    found = probability.ravel() >= scenario.detection_threshold
    for cell in objects:
        _cell(image, int(cell), columns)[_ring()] = _FOUND if found[cell] else _OBJECT
    return np.ascontiguousarray(np.concatenate([image[::-1], legend(_entries(scenario, len(paths)), image.shape[1])]))


def _color(place: int) -> Image:
    color: Image = PATH_COLORS[place % len(PATH_COLORS)]
    return color


def _cell(image: Image, cell: int, columns: int) -> Image:
    """The pixels of a cell."""
    row, column = divmod(cell, columns)
    return image[row * SCALE : (row + 1) * SCALE, column * SCALE : (column + 1) * SCALE]


def _middles(cells: NDArray[np.int64], columns: int) -> NDArray[np.int64]:
    return np.stack(np.divmod(cells, columns), axis=1) * SCALE + SCALE // 2


def _draw_path(image: Image, path: NDArray[np.int64], columns: int, color: Image) -> None:
    places = _middles(path, columns)
    for start, end in zip(places[:-1], places[1:], strict=True):
        line = np.linspace(start, end, SCALE + 1).round().astype(np.int64)
        image[line[:, 0], line[:, 1]] = color
    row, column = places[-1]
    image[row - 3 : row + 4, column - 3 : column + 4] = color


def _draw_plan(image: Image, plan: NDArray[np.int64], columns: int, color: Image) -> None:
    """Dots along the way, and a cross in the goal."""
    if len(plan) < 2:
        return
    places = _middles(plan, columns)
    for start, end in zip(places[:-1], places[1:], strict=True):
        for row, column in np.linspace(start, end, 3)[:2].round().astype(np.int64):
            image[row - 1 : row + 1, column - 1 : column + 1] = color
    _cell(image, int(plan[-1]), columns)[_cross()] = color


def _ring() -> NDArray[np.bool_]:
    along = np.arange(SCALE) - (SCALE - 1) / 2
    radius = np.hypot(along[:, None], along[None, :])
    ring: NDArray[np.bool_] = (radius > SCALE / 2 - 2.5) & (radius < SCALE / 2 - 0.7)
    return ring


def _cross() -> NDArray[np.bool_]:
    along = np.abs(np.arange(SCALE) - (SCALE - 1) / 2)
    cross: NDArray[np.bool_] = (np.abs(along[:, None] - along[None, :]) <= 1) & (along[:, None] < SCALE / 2 - 1)
    return cross


def _entries(scenario: Scenario, robots: int) -> tuple[Entry, ...]:
    """What a picture can show, each with a sample: drawn as in the picture itself, on three cells in a row."""
    return (
        *((("NOT SEARCHED", _sample(_NOT_SEARCHED)),) if (scenario.traversable & ~scenario.searched).any() else ()),
        ("BLOCKED", _sample(_BLOCKED)),
        ("BELIEF", _sample(_BELIEF)),
        ("OBJECT", _marked(_OBJECT)),
        ("FOUND", _marked(_FOUND)),
        ("PLAN, GOAL", _with_plan()),
        # More robots than colors are not told apart.
        *((("PATH", _with_path(0)),) if robots == 1 else ()),
        *((f"ROBOT {place + 1}", _with_path(place)) for place in range(robots) if 1 < robots <= len(PATH_COLORS)),
        *((("ROBOTS", _with_path(0)),) if robots > len(PATH_COLORS) else ()),
    )


def _sample(color: NDArray[np.float64], cells: int = 1) -> Image:
    return np.broadcast_to(color.astype(np.uint8), (SCALE, cells * SCALE, 3)).copy()


def _marked(color: Image) -> Image:
    sample = _sample(_OPEN)
    sample[_ring()] = color
    return sample


def _with_plan() -> Image:
    sample = _sample(_OPEN, 2)
    _draw_plan(sample, np.arange(2), 2, _color(0))
    return sample


def _with_path(place: int) -> Image:
    sample = _sample(_OPEN, 2)
    _draw_path(sample, np.arange(2), 2, _color(place))
    return sample
