"""What all environments share: a native part that holds the search, and copies of it."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
from numpy.typing import NDArray
from typing_extensions import Self

from .window import Window

#: Arrays of the native part that have a row for each search; the others have one for each robot.
_OF_SEARCHES = ("over", "f1", "recall", "time_seconds", "state")


def shaped(arrays: dict[str, NDArray[Any]], lead: tuple[int, ...]) -> dict[str, NDArray[Any]]:
    """Views of the native part's arrays: those of robots with the axes ``lead`` in front."""
    return {
        name: array if name in _OF_SEARCHES or len(lead) == 1 else array.reshape(*lead, *array.shape[1:])
        for name, array in arrays.items()
    }


class NativeEnv:
    """An environment over a native part: it can be closed, shown in a window, cloned, deep-copied and pickled.

    A copy has the same future: the same actions see the same noise, and the same sequence of episodes follows. A pickle
    holds the seed and the actions since :meth:`reset`, which are taken again when it is read. The window is no part of a
    copy: one with ``render_mode="human"`` does not render.
    """

    #: Attributes that belong to the native part; a copy gets its own.
    _OF_NATIVE = ("_native", "_arrays", "_views")
    #: Attributes that copies share, since nothing changes them.
    _SHARED = (
        "scenario",
        "observation_space",
        "single_observation_space",
        "robot_observation_space",
        "_observation_space",
        "state_space",
        "single_state_space",
        "_observer",
    )

    metadata: dict[str, Any]
    render_mode: str | None
    closed = False
    _window: Window | None = None

    def clone(self) -> Self:
        """Another environment in the same state, with the same future; neither changes the other."""
        other = object.__new__(type(self))
        for name, value in self.__dict__.items():
            if name not in self._OF_NATIVE and name != "_window":
                other.__dict__[name] = value if name in self._SHARED else copy.deepcopy(value)
        other._leave_window()
        other._connect(self._native_copy())
        return other

    def close(self) -> None:
        """Ends the environment: whatever is called then raises ``RuntimeError``. A second call does nothing."""
        self.closed = True
        if self._window is not None:
            self._window.close()
            self._window = None

    def __deepcopy__(self, memo: dict[int, object]) -> Self:
        return self.clone()

    def __getstate__(self) -> dict[str, Any]:
        state = {name: value for name, value in self.__dict__.items() if name not in (*self._OF_NATIVE, "_window")}
        return state | {"_history": self._history()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        history = state.pop("_history")
        self.__dict__.update(state)
        self._leave_window()
        self._connect(self._new_native())
        self._replay(history)

    def _open_window(self, title: str) -> None:
        """Makes the window, so that an environment without what it needs is refused before its first step."""
        if self.render_mode == "human":
            self._window = Window(title)

    def _leave_window(self) -> None:
        if self.render_mode == "human":
            self.render_mode = None

    def _show(self) -> None:
        """Shows the picture in the window, if there is one."""
        if self._window is not None:
            self._window.show(self._picture(0), self.metadata["render_fps"])

    def _picture(self, place: int) -> NDArray[np.uint8]:
        """The picture of a search."""
        raise NotImplementedError

    def _check_open(self, call: str) -> None:
        if self.closed:
            raise RuntimeError(f"{call} of an environment that is closed; make a new one")

    def _new_native(self) -> Any:
        """A native part before its first reset."""
        raise NotImplementedError

    def _native_copy(self) -> Any:
        """A native part in the same state."""
        raise NotImplementedError

    def _connect(self, native: Any) -> None:
        """Takes a native part and its arrays."""
        raise NotImplementedError

    def _history(self) -> Any:
        """What makes the state of the native part again."""
        raise NotImplementedError

    def _replay(self, history: Any) -> None:
        """Makes a state again."""
        raise NotImplementedError
