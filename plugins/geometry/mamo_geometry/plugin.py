"""Registers the geometry parts; numba is imported only when one of them is built."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from mamo_core.hookspecs import Component, hookimpl
from mamo_geometry.options import KinematicsOptions, RRTConnectOptions, SphereCheckerOptions

if TYPE_CHECKING:
    from mamo_core.build_context import BuildContext


def _kinematics(context: BuildContext, options: KinematicsOptions) -> Any:
    from mamo_geometry.kinematics import ChainKinematics

    return ChainKinematics(context.problem.scene, context.robot, options)


def _spheres(context: BuildContext, options: SphereCheckerOptions) -> Any:
    from mamo_geometry.sphere_checker import SphereChecker

    return SphereChecker(context.problem.scene, context.robot, options)


def _rrt_connect(context: BuildContext, options: RRTConnectOptions) -> Any:
    from mamo_geometry.rrt_connect import RRTConnect

    return RRTConnect(context.robot, options)


@hookimpl
def mamo_kinematics() -> Iterable[Component]:
    """Damped least squares for any serial arm."""
    return [
        Component("dls", _kinematics, KinematicsOptions, "damped least squares with restarts"),
    ]


@hookimpl
def mamo_collision_checkers() -> Iterable[Component]:
    """Sphere covers (fast, conservative)."""
    return [
        Component(
            "spheres",
            _spheres,
            SphereCheckerOptions,
            "conservative sphere covers against boxes and cylinders",
            provides=frozenset({"conservative", "hands_free", "swept_region", "sphere_arrays"}),
        ),
    ]


@hookimpl
def mamo_arm_planners() -> Iterable[Component]:
    """RRT-Connect."""
    return [
        Component(
            "rrt_connect",
            _rrt_connect,
            RRTConnectOptions,
            "bidirectional tree search with goal sets",
            requires={"collision": frozenset({"sphere_arrays"})},
        ),
    ]


def warm_up() -> None:
    """Compile the kernels (or read them from numba's cache)."""
    from mamo_geometry.warmup import warm_up as compile_all

    compile_all()
