"""Pick and place (thesis 6.3.1): grasp from the side, carry without contact, put down.

Only the end of a path counts, and where the object does not fit there a free place near it may do;
without a path it goes to any free place outside the region.
By construction the fingers close on the object: they are commanded to less than its width, one on
each side of it, and the verifier checks on exact meshes that they do. Everything but closing on the
object and letting go of it is planned free of contacts, which the verifier checks, too.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator

import numpy as np

from mamo_core.interfaces.action_generator import ActionGenerator, ActionRequest
from mamo_core.interfaces.arm_planner import ArmPlanner
from mamo_core.interfaces.collision_checker import CollisionChecker, CollisionWorld
from mamo_core.interfaces.kinematics import Kinematics
from mamo_core.robots.model import ArmModel
from mamo_core.types.action import RearrangementAction
from mamo_core.types.geometry import Array, z_axes
from mamo_core.types.problem import Problem
from mamo_core.types.scene import SceneState
from mamo_core.types.solution import Statistics
from mamo_planners.actions.grasp_set import GraspSet, grasps_of
from mamo_planners.actions.handling import Drop, Handling, Parts, Pickup
from mamo_planners.actions.pick_place_motion import MotionMaker
from mamo_planners.actions.placement import FreeSpots, moved_to, turned, turns
from mamo_planners.ignoring import IgnoringChecker
from mamo_planners.options import PickPlaceOptions

_KIND = "pick_place"


class PickPlace(ActionGenerator):
    """Every proposal is one whole pick and place that starts and ends with a closed gripper."""

    def __init__(
        self,
        problem: Problem,
        arm: ArmModel,
        kinematics: Kinematics,
        collision: CollisionChecker,
        arm_planner: ArmPlanner,
        options: PickPlaceOptions,
    ) -> None:
        self._problem, self._scene, self._arm, self._options = problem, problem.scene, arm, options
        self._arm_planner = arm_planner
        self._parts = Parts(problem, arm, kinematics, collision, options)
        self._maker = MotionMaker(arm, kinematics, options)
        self._grasps: dict[str, GraspSet] = {}

    def propose(
        self,
        state: SceneState,
        request: ActionRequest,
        rng: np.random.Generator,
        statistics: Statistics,
    ) -> Iterator[RearrangementAction]:
        query = _Query(self, state, request, rng, statistics)
        grasps = self._grasps_of(request.object_name)
        if not len(grasps):
            query.failed("ungraspable")
            return
        if query.tipped():
            query.failed("tipped")
            return
        yield from query.actions(grasps)

    def without(self, names: Collection[str]) -> ActionGenerator:
        """Where they stand is no free place either way."""
        parts = self._parts
        checker = IgnoringChecker(parts.collision, names)
        args = parts.problem, parts.arm, parts.kinematics, checker, self._arm_planner
        return PickPlace(*args, parts.options)

    def _grasps_of(self, name: str) -> GraspSet:
        if name not in self._grasps:
            shape = self._scene.objects[self._scene.index(name)].shape
            self._grasps[name] = grasps_of(shape, self._arm)
        return self._grasps[name]


class _Query:
    """One request at one state."""

    def __init__(
        self,
        action: PickPlace,
        state: SceneState,
        request: ActionRequest,
        rng: np.random.Generator,
        statistics: Statistics,
    ) -> None:
        self._a, self._state, self._request = action, state, request
        self._rng, self._stats = rng, statistics
        self._scene = action._problem.scene
        self._number = self._scene.index(request.object_name)
        self._shape = self._scene.objects[self._number].shape
        self._pose = state.object_poses[self._number]
        self._starts: dict[float, tuple[Array | None, Array] | None] = {}

    def failed(self, cause: str, times: int = 1) -> None:
        """Count a failure."""
        self._stats.failed(self._request.object_name, _KIND, cause, times)

    def tipped(self) -> bool:
        """Whether the object no longer stands upright."""
        limit = np.cos(np.radians(self._a._options.largest_tilt_deg))
        return bool(z_axes(self._pose[None, :])[0, 2] < limit)

    def actions(self, grasps: GraspSet) -> Iterator[RearrangementAction]:
        """Proposals, computed when asked for."""
        with self._stats.timed("pick_place_poses"):
            handling = Handling(
                self._a._parts, self._state, self._number, grasps, self._rng, self.failed
            )
            if not handling.graspable():
                return
            places = self._places()
        if not len(places):
            self.failed("no_free_place")
            return
        transfers = handling.transfers(places)
        proposed = 0
        while proposed < self._a._options.samples:
            with self._stats.timed("pick_place_poses"):
                transfer = next(transfers, None)
            if transfer is None:
                return
            with self._stats.timed("arm_planning"):
                action = self._planned(handling, *transfer)
            if action is not None:
                proposed += 1
                yield action

    def _places(self) -> Array:
        """Poses (n, 7) where the object may be put, a little above the floor."""
        options, here = self._a._options, self._pose[:2]
        found = [xy for xy in self._spots() if np.linalg.norm(xy - here) >= options.shortest]
        standing = np.array(self._pose)
        standing[2] = self._scene.workspace.floor + self._shape.height / 2.0 + options.drop_height
        ways = [moved_to(turned(standing, turn), found) for turn in turns(self._shape)]
        return np.stack(ways, axis=1).reshape(-1, 7)

    def _spots(self) -> list[Array]:
        """Places (2,): the end of the path, then others near it; or anywhere on the shelf."""
        options, region = self._a._options, self._request.region
        poses = self._state.object_poses
        spots = FreeSpots(self._scene, poses, self._number, options.spacing)
        limits = (options.draws, options.places)
        if self._request.path is None:
            return spots.draw(region, self._rng, *limits)
        end = self._request.path[-1]
        near = spots.draw(region, self._rng, *limits, around=end, within=options.nearby)
        return [end, *near]

    def _planned(
        self, handling: Handling, pickup: Pickup, drops: list[Drop]
    ) -> RearrangementAction | None:
        """The whole action, if the arm gets to the object, carries it there and gets away."""
        if pickup.opening not in self._starts:
            self._starts[pickup.opening] = self._opened(handling, pickup.opening)
        opened = self._starts[pickup.opening]
        if opened is None:
            return None
        first, start = opened
        everything = handling.world(pickup.opening, without=False)
        transit = self._path("transit", start, pickup.reach[0], everything)
        if transit is None:
            return None
        for drop in drops:  # in their order: the first is nearest to where it was asked to be
            ways = self._carried(handling, pickup, drop)
            if ways is not None:
                motion = self._a._maker.motion(
                    self._request.object_name, pickup, drop, first, transit, *ways
                )
                path = np.stack([self._pose[:2], drop.pose[:2]])
                return RearrangementAction(_KIND, self._request.object_name, motion, path)
        return None

    def _carried(
        self, handling: Handling, pickup: Pickup, drop: Drop
    ) -> tuple[Array, Array | None] | None:
        """The carry (k, dof) and, if the gripper cannot close after the retract, the way home."""
        over = drop.lower[0]
        carry = self._path("carry", pickup.lift[-1], over, handling.carrying(pickup))
        if carry is None or drop.clear:
            return None if carry is None else (carry, None)
        placed = handling.placed(drop.pose, pickup.opening)
        away = self._path("away", drop.retract[-1], self._a._problem.home, placed)
        return None if away is None else (carry, away)

    def _opened(self, handling: Handling, opening: float) -> tuple[Array | None, Array] | None:
        """A closed transit (k, dof) to where the gripper can open, if needed, and where that is."""
        here = self._state.joint_positions
        if handling.world(opening, without=False).free(here)[0]:
            return None, here
        closed = handling.world(self._a._arm.gripper.closed, without=False)
        home = self._path("open", here, self._a._problem.home, closed)
        return None if home is None else (home, home[-1])

    def _path(self, what: str, start: Array, goal: Array, world: CollisionWorld) -> Array | None:
        """A path (k, dof) to ``goal`` (dof,); failures are counted."""
        checks = self._a._options.max_checks
        plan = self._a._arm_planner.plan(start, goal[None, :], world, self._rng, max_checks=checks)
        self._stats.counts["arm_plans"] += 1
        if plan.path is None:
            self.failed(f"{what}_{plan.status}")
        return plan.path
