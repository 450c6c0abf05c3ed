"""Ways to rearrange one object."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass

import numpy as np

from mamo_core.types.action import RearrangementAction
from mamo_core.types.geometry import Array
from mamo_core.types.region import SweptRegion
from mamo_core.types.scene import SceneState
from mamo_core.types.solution import Statistics


@dataclass(frozen=True, eq=False)
class ActionRequest:
    """Bring ``object_name`` along ``path`` (k, 2), world xy from where it is, out of ``region``.

    ``path`` is None for a goal-agnostic request: any motion that lessens the overlap will do.
    """

    object_name: str
    path: Array | None
    region: SweptRegion


class ActionGenerator(ABC):
    """Proposes actions for one problem. Its name is the ``kind`` of what it proposes."""

    @abstractmethod
    def propose(
        self,
        state: SceneState,
        request: ActionRequest,
        rng: np.random.Generator,
        statistics: Statistics,
    ) -> Iterator[RearrangementAction]:
        """Actions that start at ``state``'s configuration, best first, computed when asked for.

        Failures are counted in ``statistics`` by cause.
        """

    def progress(
        self, before: SceneState, request: ActionRequest
    ) -> Callable[[SceneState], bool] | None:
        """Whether a state after an action, begun at ``before``, is what it was for.

        None: the search judges that, which is the default.
        """
        return None

    def alike(self, action: RearrangementAction, failed: RearrangementAction) -> bool:
        """Whether an action is so like one that failed at the same state that it will fail, too.

        By default none is. Both are proposals of this generator.
        """
        return False

    def without(self, names: Collection[str]) -> ActionGenerator | None:
        """A generator as if some things were not there, to find out what they block.

        None: this generator cannot tell, which is the default.
        """
        return None
