"""A rearrangement action: a motion meant to bring one object somewhere else."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from mamo_core.types.geometry import Array, frozen_array
from mamo_core.types.motion import Motion


@dataclass(frozen=True, eq=False)
class RearrangementAction:
    """``kind`` is the generator's name; ``path`` (k, 2) world xy the object should follow."""

    kind: str
    object_name: str
    motion: Motion
    path: Array
    info: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "path", frozen_array(self.path, "action path", (None, 2)))
