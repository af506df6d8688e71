"""The choices of environments, and the checks of what they are given."""

from __future__ import annotations

import operator
from collections.abc import Sequence
from typing import Any, Literal

#: What an action names: a cell to go to, or a step to a neighbor.
Control = Literal["waypoint", "step"]
#: What an action is rewarded with.
Reward = Literal["entropy", "found", "f1"]
#: When an episode terminates.
End = Literal["all_found", "resting"]
#: What an action does that cannot be taken.
MaskedAction = Literal["stay", "error"]
#: What an observation is.
ObservationKind = Literal["dict", "planes", "graph", "belief"]
#: Where the origin of an observation is.
Frame = Literal["map", "robot"]
#: Where ``render`` draws: a window, or an array. Many environments at once have no window.
RenderMode = Literal["human", "rgb_array"]
VectorRenderMode = Literal["rgb_array"]


def check_render_mode(mode: str | None, known: Sequence[str]) -> None:
    """Refuses a render mode that there is not."""
    if mode is not None and mode not in known:
        allowed = ", ".join(f'"{name}"' for name in known)
        raise ValueError(f'render_mode="{mode}"; allowed are None and {allowed}')


def as_action(action: object, of: str = "action") -> int:
    """An action as the integer that it is."""
    try:
        return operator.index(action)  # type: ignore[arg-type]
    except TypeError:
        raise TypeError(f"{of} {action!r} of type {type(action).__name__}; allowed is an integer") from None


def as_count(number: object, of: str) -> int:
    """A count of at least one."""
    count = as_action(number, of)
    if count < 1:
        raise ValueError(f"{of}={count}; allowed is at least 1")
    return count


def as_seed(seed: object) -> int:
    """A seed as the episode's: 64 bits."""
    number = as_action(seed, "seed")
    if not 0 <= number < 2**64:
        raise ValueError(f"seed {number}; allowed are 0 to 2**64 - 1")
    return number


def check_options(options: dict[str, Any] | None, known: list[str]) -> None:
    """Refuses options that would otherwise be ignored."""
    for name in options or {}:
        if name not in known:
            allowed = ", ".join(known) if known else "none"
            raise ValueError(f"option {name!r}; allowed is {allowed}")
