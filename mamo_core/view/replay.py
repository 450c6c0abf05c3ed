"""Recordings as videos, as moving GIFs, and as pictures of the start and the end."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from mamo_core.errors import PluginError
from mamo_core.interfaces.renderer import Image, Renderer, Shot
from mamo_core.types.geometry import IntArray
from mamo_core.types.recording import Recording
from mamo_core.view.captions import broken_by_then, caption, engines, write_on
from mamo_core.view.shots import shot_of

_HELD = 1.0
"""How long the last picture stays, s."""
_GIF_COLORS = 96
_TICK = 0.01
"""The times of a GIF are multiples of this, s."""
_QUALITY = ["-preset", "veryfast", "-crf", "20", "-movflags", "+faststart"]


@dataclass(frozen=True)
class Film:
    """``fps``: pictures a second; ``width``, ``height``: pixels; ``speed``: 2 is twice as fast."""

    fps: float
    width: int
    height: int
    speed: float = 1.0


MP4 = Film(fps=20.0, width=640, height=480)
GIF = Film(fps=10.0, width=480, height=360)
STILL = Film(fps=1.0, width=800, height=600)
"""What is made unless something else is asked for; of a still only the size counts."""


def write_mp4(path: str | Path, recording: Recording, renderer: Renderer, film: Film = MP4) -> None:
    """A video in H.264, which all players know; its pixels must be even in number.

    Raises:
        PluginError: the package that brings the encoder is missing, or nothing can draw.
    """
    try:
        from imageio_ffmpeg import write_frames
    except ImportError as error:
        raise PluginError(f"{error}; install it with: pip install 'mamo[view]'") from error
    pictures = _pictures(recording, renderer, film)
    first = next(pictures)  # before the encoder starts: nothing may be able to draw
    video = write_frames(
        str(path),
        (film.width, film.height),
        fps=film.fps,
        codec="libx264",
        quality=None,
        macro_block_size=2,
        output_params=_QUALITY,
    )
    video.send(None)
    try:
        for image in chain([first], pictures):
            video.send(np.ascontiguousarray(image))
        for _ in range(round(_HELD * film.fps)):
            video.send(np.ascontiguousarray(image))
    finally:
        video.close()


def write_gif(path: str | Path, recording: Recording, renderer: Renderer, film: Film = GIF) -> None:
    """A moving GIF, which pages and forges show by themselves.

    Raises:
        PluginError: nothing can draw.
    """
    step = max(round(1.0 / (film.fps * _TICK)), 2) * _TICK  # viewers slow down shorter ones
    film = replace(film, fps=1.0 / step)
    palette = _palette(recording, renderer, film)
    images = [_with_colors(image, palette) for image in _pictures(recording, renderer, film)]
    times = [round(1000.0 * step)] * (len(images) - 1) + [round(1000.0 * (step + _HELD))]
    images[0].save(path, save_all=True, append_images=images[1:], duration=times, loop=0)


def write_still(
    path: str | Path, recording: Recording, renderer: Renderer, film: Film = STILL
) -> None:
    """A PNG of the start and of the end, side by side.

    Raises:
        PluginError: nothing can draw.
    """
    from PIL import Image as Pillow

    last = len(recording.times) - 1
    before, after = renderer.frames(recording, [0, last], _shot(recording, film))
    pair = (
        write_on(before, "before"),
        write_on(after, _joined("after", engines(recording)), broken_by_then(recording, last)),
    )
    Pillow.fromarray(np.hstack(pair)).save(path)


def rows_of(recording: Recording, film: Film) -> IntArray:
    """The rows of the recording that are shown, from the first to the last one."""
    duration = float(recording.times[-1])
    wanted = np.arange(0.0, duration, film.speed / film.fps)
    found = np.searchsorted(recording.times, wanted - 1e-9)
    return np.append(found, len(recording.times) - 1)


def _pictures(recording: Recording, renderer: Renderer, film: Film) -> Iterator[Image]:
    rows = rows_of(recording, film).tolist()
    note = _joined(engines(recording), "" if film.speed == 1.0 else f"{film.speed:g}x")
    frames = renderer.frames(recording, rows, _shot(recording, film))
    for row, image in zip(rows, frames, strict=True):
        text = _joined(caption(recording, row), note)
        yield write_on(image, text, broken_by_then(recording, row))


def _joined(*parts: str) -> str:
    return "   ".join(part for part in parts if part)


def _shot(recording: Recording, film: Film) -> Shot:
    return shot_of(recording.problem, film.width, film.height)


def _palette(recording: Recording, renderer: Renderer, film: Film) -> Any:
    """One set of colours for all pictures, without which they flicker: of the start and the end."""
    from PIL import Image as Pillow

    rows = [0, len(recording.times) - 1]
    images = renderer.frames(recording, rows, _shot(recording, film))
    texts = [(caption(recording, row), broken_by_then(recording, row)) for row in rows]
    both = np.vstack([write_on(image, *text) for image, text in zip(images, texts, strict=True)])
    return Pillow.fromarray(both).quantize(_GIF_COLORS, method=Pillow.Quantize.MEDIANCUT)


def _with_colors(image: Image, palette: Any) -> Any:
    from PIL import Image as Pillow

    return Pillow.fromarray(image).quantize(palette=palette, dither=Pillow.Dither.NONE)
