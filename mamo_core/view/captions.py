"""What stands in the pictures of a replay: which action, what time, what went wrong."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from mamo_core.interfaces.renderer import Image
from mamo_core.types.recording import Recording

_SIZE = 0.036
"""Height of letters, and of the margin beside them, relative to the height of the picture."""
_INK, _PAPER, _ALARM = (40, 44, 48), (255, 255, 255, 200), (176, 0, 32)


def caption(recording: Recording, row: int) -> str:
    """The action of that row and its number, and the time."""
    number = next(s.motion for s in recording.stretches if s.first <= row <= s.last)
    count = len(recording.plan.motions)
    return f"{number + 1}/{count}  {recording.title(number)}   {recording.times[row]:.1f} s"


def broken_by_then(recording: Recording, row: int) -> tuple[str, ...]:
    """What the first engine had violated by that row, in words, each constraint and pair once."""
    time = float(recording.times[row])
    past = recording.executions[0].broken_by(time)
    words = [f"{v.constraint}: {v.subject}" + (f", {v.other}" if v.other else "") for v in past]
    return tuple(dict.fromkeys(words))


def engines(recording: Recording) -> str:
    """Whose execution is seen; empty if there is one only."""
    first, *others = [execution.engine for execution in recording.executions]
    return f"{first} (as ghosts: {', '.join(others)})" if others else ""


def write_on(image: Image, text: str, alarm: tuple[str, ...] = ()) -> Image:
    """The picture with a line of text at its top, and a red one for each ``alarm``."""
    from PIL import Image as Pillow
    from PIL import ImageDraw

    picture = Pillow.fromarray(image)
    draw = ImageDraw.Draw(picture, "RGBA")
    size = max(round(_SIZE * image.shape[0]), 9)
    for line, words in enumerate((text, *alarm)):
        place = (size, size + 2 * size * line)
        box = draw.textbbox(place, words, font=_font(size))
        pad = size // 2
        draw.rectangle((box[0] - pad, place[1] - pad, box[2] + pad, place[1] + size + pad), _PAPER)
        draw.text(place, words, _ALARM if line else _INK, font=_font(size))
    return np.asarray(picture)


@lru_cache(maxsize=4)
def _font(size: int) -> Any:
    from PIL import ImageFont

    return ImageFont.load_default(size)
