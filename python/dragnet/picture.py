"""Pictures of a search, in plain NumPy."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .scenario import Scenario

#: Edge of a cell, pixels.
SCALE = 12

_OPEN = np.array([255, 255, 255], dtype=np.float64)
_PASSAGE = np.array([225, 225, 225], dtype=np.float64)
_BLOCKED = np.array([60, 60, 60], dtype=np.float64)
_BELIEF = np.array([214, 40, 40], dtype=np.float64)
_WAYS = np.array([[31, 119, 180], [255, 127, 14], [148, 103, 189], [140, 86, 75], [23, 190, 207]], dtype=np.uint8)
_OBJECT = np.array([0, 0, 0], dtype=np.uint8)
_FOUND = np.array([44, 160, 44], dtype=np.uint8)


def draw(
    scenario: Scenario,
    probability: NDArray[np.float32],
    ways: Sequence[NDArray[np.int64]],
    objects: NDArray[np.int64],
) -> NDArray[np.uint8]:
    """Map, belief, ways (each ends where its robot stands) and objects; north up, shape ``(height, width, 3)``."""
    rows, columns = scenario.shape
    ground = np.where(scenario.searched[..., None], _OPEN, _PASSAGE)
    ground = np.where(scenario.traversable[..., None], ground, _BLOCKED)
    share = np.sqrt(probability.astype(np.float64))[..., None]
    cells = (ground * (1.0 - share) + _BELIEF * share).astype(np.uint8)
    image = np.repeat(np.repeat(cells, SCALE, axis=0), SCALE, axis=1)
    for place, way in enumerate(ways):
        _draw_way(image, way, columns, _WAYS[place % len(_WAYS)])
    found = probability.ravel() >= scenario.detection_threshold
    ring = _ring()
    for cell in objects:
        row, column = divmod(int(cell), columns)
        corner = image[row * SCALE : (row + 1) * SCALE, column * SCALE : (column + 1) * SCALE]
        corner[ring] = _FOUND if found[cell] else _OBJECT
    return np.ascontiguousarray(image[::-1])


def _draw_way(image: NDArray[np.uint8], way: NDArray[np.int64], columns: int, color: NDArray[np.uint8]) -> None:
    rows_at, columns_at = np.divmod(way, columns)
    places = np.stack([rows_at, columns_at], axis=1) * SCALE + SCALE // 2
    for start, end in zip(places[:-1], places[1:], strict=True):
        line = np.linspace(start, end, SCALE + 1).round().astype(np.int64)
        image[line[:, 0], line[:, 1]] = color
    row, column = places[-1]
    image[row - 3 : row + 4, column - 3 : column + 4] = color


def _ring() -> NDArray[np.bool_]:
    along = np.arange(SCALE) - (SCALE - 1) / 2
    radius = np.hypot(along[:, None], along[None, :])
    ring: NDArray[np.bool_] = (radius > SCALE / 2 - 2.5) & (radius < SCALE / 2 - 0.7)
    return ring
