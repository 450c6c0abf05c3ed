"""Backwards search for what is in the way (Dogar and Srinivasa, 2012; thesis 4.5.1, 5.6.1).

The last motion, the retrieval, is planned first. What stands in its swept volume has to be pushed
out before; what stands in the volume of those pushes before that, and so on. An object is pushed
once at most, to a place near the closest one outside of all volumes found so far.
"""

from __future__ import annotations

import numpy as np

from mamo_core.interfaces.action_generator import ActionRequest
from mamo_core.interfaces.collision_checker import CollisionChecker
from mamo_core.interfaces.search_strategy import ProgressCallback, SearchStrategy
from mamo_core.types.action import RearrangementAction
from mamo_core.types.geometry import Array
from mamo_core.types.mapf import MAPFBudget
from mamo_core.types.motion import Motion
from mamo_core.types.region import SweptRegion
from mamo_core.types.scene import SceneState, displacements
from mamo_core.types.solution import Budget, Plan, Solution, SolutionStatus
from mamo_planners.baselines.options import DogarOptions
from mamo_planners.search.abstraction import occupied
from mamo_planners.search.judging import Accept
from mamo_planners.search.run import SearchParts, SearchRun

_UNMOVED = 0.01
_HOPELESS = 25
_SLIDE_STEP = 0.01


class Dogar(SearchStrategy):
    """Recursions from new retrievals until one executes forwards and is verified."""

    def __init__(
        self, parts: SearchParts, collision: CollisionChecker, options: DogarOptions
    ) -> None:
        self._parts, self._collision, self._options = parts, collision, options

    def solve(
        self, budget: Budget, rng: np.random.Generator, progress: ProgressCallback
    ) -> Solution:
        run = SearchRun(self._parts, budget, rng, progress, 1, MAPFBudget(), 0.0)
        hopeless = 0
        for number in range(self._options.attempts):
            progress(f"attempt {number + 1}")
            run.statistics.counts["attempts"] += 1
            retrieval = run.retrieval_without_movables()
            if retrieval is not None:
                plan = _Recursion(run, self._collision, self._options).solve(retrieval)
                if plan is not None:
                    return Solution(SolutionStatus.SOLVED, plan, run.statistics)
            hopeless += retrieval is None
            if hopeless >= _HOPELESS:
                return run.no_retrieval()
            if budget.exhausted:
                break
        return run.no_plan()


class _Recursion:
    """One backwards search: pushes are found last first."""

    def __init__(self, run: SearchRun, collision: CollisionChecker, options: DogarOptions) -> None:
        self._run, self._collision, self._options = run, collision, options
        self._problem = run.parts.problem
        self._pushed: dict[str, RearrangementAction] = {}

    def solve(self, retrieval: Motion) -> Plan | None:
        """A verified plan that ends with ``retrieval``."""
        initial = self._problem.initial
        first = self._run.swept_by(retrieval)
        region = first
        while True:
            inside = [n for n in occupied(self._problem, initial, region) if n not in self._pushed]
            if not inside:
                return self._forwards(retrieval, first)
            name = inside[int(self._run.rng.integers(len(inside)))]
            action = self._push(name, region)
            if action is None:
                return None
            self._pushed[name] = action
            region = region.united(self._swept(name, action, region))

    def _push(self, name: str, region: SweptRegion) -> RearrangementAction | None:
        """A push that takes the object out of the region and leaves those pushed later alone."""
        run, start = self._run, self._run.execution.start
        closest = self._closest_outside(name, region)
        if closest is None:
            run.statistics.failed(name, "push", "no_place")
            return None
        here = self._problem.initial.object_poses[self._problem.scene.index(name)][:2]
        for _ in range(self._options.goals):
            goal = closest + run.rng.normal(scale=self._options.goal_spread, size=2)
            request = ActionRequest(name, np.stack([here, goal]), region)
            found = run.realise(start, "push", request, self._cleared(name, region))
            if found is not None:
                return found[0]
            if run.budget.exhausted:
                return None
        return None

    def _cleared(self, name: str, region: SweptRegion) -> Accept:
        scene, initial = self._problem.scene, self._problem.initial
        place = scene.index(name)
        later = [scene.index(other) for other in self._pushed]

        def accept(after: SceneState) -> bool:
            unmoved = (displacements(initial, after)[later] < _UNMOVED).all()
            return bool(unmoved) and not region.overlaps(
                scene.objects[place].shape, after.object_poses[place]
            )

        return accept

    def _closest_outside(self, name: str, region: SweptRegion) -> Array | None:
        """The closest place (2,) in the workspace where the object is outside the region."""
        scene, place = self._problem.scene, self._problem.scene.index(name)
        shape, pose = scene.objects[place].shape, self._problem.initial.object_poses[place]
        lower, upper = scene.workspace.lower[:2], scene.workspace.upper[:2]
        axes = [np.arange(a, b, self._options.cell) for a, b in zip(lower, upper, strict=True)]
        points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
        for point in points[np.argsort(np.linalg.norm(points - pose[:2], axis=1), kind="stable")]:
            moved = np.array(pose)
            moved[:2] = point
            if not region.overlaps(shape, moved):
                return np.array(point)
        return None

    def _swept(self, name: str, action: RearrangementAction, region: SweptRegion) -> SweptRegion:
        """What the arm sweeps while it pushes, and the object."""
        swept = region
        for segment in action.motion.after_transit().segments:
            swept = swept.united(
                self._collision.swept_region(segment.trajectory.positions, opening=segment.opening)
            )
        lowest = np.array(swept.lowest)
        place = self._problem.scene.index(name)
        shape, pose = (
            self._problem.scene.objects[place].shape,
            np.array(self._problem.initial.object_poses[place]),
        )
        way = action.path[-1] - pose[:2]
        steps = max(2, int(np.ceil(np.linalg.norm(way) / _SLIDE_STEP)))
        start = pose[:2].copy()
        for share in np.linspace(0.0, 1.0, steps):
            pose[:2] = start + share * way
            lowest[swept.touched_cells(shape, pose)] = swept.floor
        return SweptRegion(swept.origin, swept.resolution, lowest, swept.floor)

    def _forwards(self, retrieval: Motion, region: SweptRegion) -> Plan | None:
        """Executes what was found, in its real order."""
        run, stand = self._run, self._run.execution.start
        done: list[RearrangementAction] = []
        for action in reversed(self._pushed.values()):
            motion = run.execution.approached_anew(stand, action.motion, run.rng)
            if motion is None:
                return None
            anew = RearrangementAction(
                action.kind, action.object_name, motion, action.path, action.info
            )
            after = run.execution.executed(stand, anew, None)
            if after is None:
                return None
            stand = after
            done.append(anew)
        return run.confirmed(stand, tuple(done), retrieval, region)
