"""A window on the screen that shows pictures: ``render_mode="human"``."""

from __future__ import annotations

import os

import numpy as np
from gymnasium.error import DependencyNotInstalled
from numpy.typing import NDArray


class Window:
    """Opens with the first picture."""

    def __init__(self, title: str):
        # It would greet on the standard output.
        os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
        try:
            import pygame
        except ImportError:
            raise DependencyNotInstalled(
                'render_mode="human" needs pygame: pip install \'dragnet[human]\'; "rgb_array" needs nothing'
            ) from None
        self._pygame = pygame
        self._title = title
        self._clock = pygame.time.Clock()

    def show(self, image: NDArray[np.uint8], frames_per_second: float) -> None:
        """Shows a picture, and waits for as long as the last one is to be seen."""
        pygame = self._pygame
        size = image.shape[1], image.shape[0]
        pygame.display.init()
        screen = pygame.display.get_surface()
        if screen is None or screen.get_size() != size:
            screen = pygame.display.set_mode(size)
            pygame.display.set_caption(self._title)
        # Pygame's first axis is that of columns.
        screen.blit(pygame.surfarray.make_surface(image.swapaxes(0, 1)), (0, 0))
        # A window that takes no events counts as hung.
        pygame.event.pump()
        pygame.display.flip()
        self._clock.tick(frames_per_second)

    def close(self) -> None:
        """Closes the window."""
        self._pygame.display.quit()
