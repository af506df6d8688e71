"""Recordings drawn with matplotlib."""

from __future__ import annotations

import os
from math import degrees
from typing import TYPE_CHECKING

import numpy as np

from .picture import PATH_COLORS
from .recording import Recording, read_recording

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def plot(recording: Recording | str | os.PathLike[str], axes: Axes | None = None) -> Axes:
    """Draws a recording, or the one of a file: map, belief at the end, every robot's path and the declared finds, with a
    legend; in the frame ``map``, meters. It returns the axes: ``dragnet.plot("search.mcap").figure.savefig("search.png")``.

    Without ``axes`` it draws on those of a new figure. Raises ``ImportError`` without matplotlib.
    """
    try:
        import matplotlib.pyplot as plt
        from matplotlib.transforms import Affine2D
    except ImportError:
        raise ImportError("dragnet.plot needs matplotlib: pip install 'dragnet[pictures]'") from None
    if not isinstance(recording, (Recording, str, os.PathLike)):
        raise TypeError(f"recording of type {type(recording).__name__}; allowed is a Recording or the path of a file")
    mission = recording if isinstance(recording, Recording) else read_recording(recording)
    if axes is None:
        axes = plt.subplots(layout="constrained")[1]
    rows, columns = mission.traversable.shape
    x, y, yaw = mission.origin
    edges = np.array([0, columns, 0, rows]) * mission.cell_meters
    from_corner = Affine2D().rotate(yaw).translate(x, y) + axes.transData
    images = [
        # White where nothing is searched but robots can be: there is no belief.
        axes.imshow(np.where(mission.traversable, np.nan, 0.25), cmap="gray", vmin=0, vmax=1, origin="lower"),
        axes.imshow(
            np.where(mission.searched, mission.probability, np.nan), cmap="Reds", vmin=0, vmax=1, origin="lower"
        ),
    ]
    for image in images:
        image.set_extent(edges.tolist())
        image.set_transform(from_corner)
    axes.figure.colorbar(images[-1], ax=axes, label="probability of an object")
    for robot in np.unique(mission.observations["robot"]):
        if robot == 0:
            continue
        places = np.array([mission.position(cell) for cell in mission.path(robot)])
        color = PATH_COLORS[(robot - 1) % len(PATH_COLORS)] / 255
        axes.plot(*places.T, color=color, linewidth=1, marker="s", markevery=[-1], markersize=5, label=f"robot {robot}")
    if mission.statuses and len(mission.statuses[-1]["declared"]):
        x_finds, y_finds = zip(*(mission.position(cell) for cell in mission.statuses[-1]["declared"]), strict=True)
        axes.plot(x_finds, y_finds, "o", color="tab:green", fillstyle="none", markersize=9, label="declared")
    corners = np.array([[0, 0], [columns, 0], [0, rows], [columns, rows]]) * mission.cell_meters
    placed = Affine2D().rotate(yaw).translate(x, y).transform(corners)
    low, high = placed.min(axis=0), placed.max(axis=0)
    turned = f", map turned by {degrees(yaw):.0f}°" if yaw else ""
    axes.set(
        xlim=(low[0], high[0]),
        ylim=(low[1], high[1]),
        aspect="equal",
        xlabel=f"x, m{turned}",
        ylabel="y, m",
        title=mission.run.get("scenario", ""),
    )
    axes.legend(loc="upper left", fontsize="small")
    return axes
