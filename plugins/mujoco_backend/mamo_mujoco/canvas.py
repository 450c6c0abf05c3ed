"""Where MuJoCo draws: a picture in memory, by OpenGL without a screen."""

from __future__ import annotations

import ctypes
import os
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any

import mujoco
import numpy as np

from mamo_core.errors import PluginError
from mamo_core.interfaces.renderer import Image

CHOICE = "MUJOCO_GL"
"""The environment variable by which MuJoCo's users choose."""

LIBRARIES = {"egl": "libEGL.so.1", "osmesa": "libOSMesa.so.8"}
PACKAGES = "apt-get install libegl1 libgl1-mesa-dri (or libosmesa6)"


class Canvas:
    """Draws scenes of one model, ``width`` x ``height`` pixels."""

    def __init__(self, model: Any, width: int, height: int) -> None:
        self._surface = _surface(width, height)
        self._surface.make_current()
        self._context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100.value)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, self._context)
        self._rectangle = mujoco.MjrRect(0, 0, width, height)
        self._pixels = np.empty((height, width, 3), dtype=np.uint8)

    def draw(self, scene: Any) -> Image:
        """The scene as a new picture."""
        self._surface.make_current()  # there may be other canvases
        mujoco.mjr_render(self._rectangle, scene, self._context)
        mujoco.mjr_readPixels(self._pixels, None, self._rectangle, self._context)
        return np.flipud(self._pixels).copy()  # OpenGL counts rows from below

    def close(self) -> None:
        """Give back what OpenGL holds."""
        self._surface.make_current()
        self._context.free()
        self._surface.free()


@contextmanager
def open_canvas(model: Any, width: int, height: int) -> Iterator[Canvas]:
    """A canvas for as long as the block runs.

    Raises:
        PluginError: there is no library that draws without a screen, or it fails.
    """
    try:
        canvas = Canvas(model, width, height)
    except Exception as error:  # PyOpenGL, ctypes and MuJoCo each raise their own
        raise PluginError(_complaint(str(error))) from error
    try:
        yield canvas
    finally:
        canvas.close()


def _surface(width: int, height: int) -> Any:
    """What OpenGL draws on. MuJoCo itself reads the variable, too, when it first draws."""
    if not os.environ.get(CHOICE):
        os.environ[CHOICE] = _usable()
    chosen = os.environ[CHOICE].lower().strip()
    module = f"mujoco.{chosen}" if chosen in LIBRARIES else "mujoco.gl_context"
    return import_module(module).GLContext(width, height)


def _usable() -> str:
    """The first of ``LIBRARIES`` that is installed.

    PyOpenGL cannot change from one to the other, so that trying them out is not possible.
    """
    for choice, library in LIBRARIES.items():
        try:
            ctypes.CDLL(library)
        except OSError:
            continue
        return choice
    raise PluginError(f"neither of {', '.join(LIBRARIES.values())} is installed")


def _complaint(reason: str) -> str:
    return (
        f"renderer 'mujoco' cannot draw here: {' '.join(reason.split())} "
        f"({CHOICE}={os.environ.get(CHOICE, '')}); it needs OpenGL without a screen, which on "
        f"Debian comes with: {PACKAGES}"
    )
