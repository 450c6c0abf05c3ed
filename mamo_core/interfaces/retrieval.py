"""How the target is taken out: grasp, lift, extract, home."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field

import numpy as np

from mamo_core.types.motion import Motion
from mamo_core.types.region import SweptRegion
from mamo_core.types.scene import SceneState


@dataclass(frozen=True, eq=False)
class Retrieval:
    """A retrieval from home to home, or None with the number of failures by cause.

    ``grasp``: the number of the problem's grasp it uses.
    """

    motion: Motion | None
    grasp: int = -1
    causes: Mapping[str, int] = field(default_factory=dict)


class RetrievalPlanner(ABC):
    """Plans retrievals for one problem; motions start and end at home, the gripper closed."""

    @abstractmethod
    def plan(
        self,
        state: SceneState,
        rng: np.random.Generator,
        *,
        ignore_movables: bool = False,
        avoid: Collection[int] = (),
    ) -> Retrieval:
        """A contact-free retrieval among the objects of ``state``, by no grasp in ``avoid``."""

    @abstractmethod
    def swept_region(self, state: SceneState, motion: Motion) -> SweptRegion:
        """The space that ``motion`` sweeps with the arm and the held target (the NGR)."""

    def thorough(self) -> RetrievalPlanner:
        """A planner that looks at more grasps and arm configurations, at a price; or itself."""
        return self

    def without(self, names: Collection[str]) -> RetrievalPlanner | None:
        """A planner as if some immovables and fixtures were not there, to find out what they block.

        It may give up earlier. None: this planner cannot tell, which is the default.
        """
        return None
