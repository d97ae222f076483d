"""Pictures of one flight, as an array or in MuJoCo's window."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.simulation import World

_WIDTH, _HEIGHT = 640, 360  # [pixels]


class Picture:
    """What a camera behind a drone sees."""

    def __init__(self, world: World, drone_id: str) -> None:
        self._world = world
        self._camera = world[drone_id].camera("chase", _WIDTH, _HEIGHT)
        self._window: Any = None
        self._likeness: Any = None

    def render(self, mode: str | None) -> NDArray[np.uint8] | None:
        """Return a picture, or show it in the window if the mode is ``human``."""
        if mode == "human":
            self.show()
            return None
        return self.take()

    def take(self) -> NDArray[np.uint8]:
        """Return a picture, shape (360, 640, 3).

        Raises:
            RenderingError: If there is no OpenGL on this machine.
        """
        return self._camera.image()

    def show(self) -> None:
        """Show the present instant in MuJoCo's window, which opens with the first call.

        Raises:
            CrazychoirError: If the window cannot be opened.
        """
        from crazychoir_fw.recording.likeness import Likeness

        if self._window is None:
            try:
                import mujoco.viewer

                self._likeness = Likeness(self._world.model)
                shown = self._likeness.update(self._world.data)
                self._window = mujoco.viewer.launch_passive(
                    self._world.model, shown, show_left_ui=False, show_right_ui=False
                )
            except (ImportError, RuntimeError) as error:
                raise CrazychoirError(f"render_mode human: MuJoCo's window cannot be opened ({error})") from None
        if self._window.is_running():
            with self._window.lock():
                self._likeness.update(self._world.data)
            self._window.sync()

    def close(self) -> None:
        """Close the window."""
        if self._window is not None:
            self._window.close()
            self._window = None
