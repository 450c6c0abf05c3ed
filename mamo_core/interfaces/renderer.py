"""Pictures of recordings in three dimensions."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from mamo_core.types.geometry import Array
from mamo_core.types.recording import Recording
from mamo_core.types.scene import Mobility

Image = npt.NDArray[np.uint8]
"""A picture (h, w, 3): rows from the top, red, green, blue."""


@dataclass(frozen=True, eq=False)
class Shot:
    """What a camera sees, and in which colours.

    ``eye``, ``target`` (3,): where the camera stands and what is in the middle, m, world; up is z.
    ``view_angle``: vertical, rad. ``width``, ``height``: pixels. ``colors``: ``#rrggbb`` of objects
    by what may happen to them; ``broken``: of those that broke a constraint. ``outlined``: names
    of boxes of which only the edges are drawn, as they hide the rest.
    """

    eye: Array
    target: Array
    view_angle: float
    width: int
    height: int
    colors: Mapping[Mobility, str]
    broken: str
    outlined: frozenset[str] = frozenset()


class Renderer(ABC):
    """Draws recordings of one problem; no engine is asked again."""

    @abstractmethod
    def frames(self, recording: Recording, rows: Iterable[int], shot: Shot) -> Iterator[Image]:
        """One picture for each of the ``rows`` of the recording.

        Robot and objects stand where the first engine had them, and where the others had the
        objects these are seen as ghosts. An object that broke a constraint is ``broken`` from
        then on.

        Raises:
            PluginError: nothing on this machine can draw; the text says what to install.
        """
