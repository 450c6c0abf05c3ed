"""The hooks of mamo: one registration hook a role.

A plugin is a module with functions named like the hooks below, decorated with ``hookimpl`` and
registered under the entry-point group ``mamo``. Each returns the components it offers::

    from mamo_core.hookspecs import Component, hookimpl

    @hookimpl
    def mamo_actions():
        return [Component(name="nudge", build=build_nudge, options=NudgeOptions)]
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import pluggy
from pydantic import BaseModel, ConfigDict

ENTRY_POINT_GROUP = "mamo"
hookspec = pluggy.HookspecMarker("mamo")
hookimpl = pluggy.HookimplMarker("mamo")


class Options(BaseModel):
    """Base of every component's options: immutable, unknown keys refused, no NaN or infinity."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, strict=True)

    def needs(self) -> Mapping[str, frozenset[str]]:
        """Role -> capabilities that these values need from its parts, if there are any."""
        return {}


class NoOptions(Options):
    """For components that have nothing to set."""


@dataclass(frozen=True)
class Component:
    """A registered part.

    ``build(context, options)`` makes the part for one problem (see ``build_context.BuildContext``).
    ``provides``: capabilities it declares. ``requires``: role -> capabilities it needs there;
    compose refuses a recipe that lacks one before anything runs. ``tasks``: of searches, the tasks
    they plan for (see ``types.problem.Task``). ``extra``: of mamo, that installs
    the packages it needs. Of engines: ``cost``, CPU time relative to MuJoCo, cheap ones are asked
    first; ``grades``, check of the conformance suite -> how exact it is, "exact" where nothing is
    said; ``known_gaps``, check -> why it fails.
    """

    name: str
    build: Callable[[Any, Any], Any]
    options: type[Options] = NoOptions
    summary: str = ""
    provides: frozenset[str] = frozenset()
    requires: dict[str, frozenset[str]] = field(default_factory=dict)
    tasks: frozenset[str] = frozenset({"retrieve"})
    extra: str = ""
    cost: float = 1.0
    grades: Mapping[str, str] = field(default_factory=dict)
    known_gaps: Mapping[str, str] = field(default_factory=dict)


class HookSpecs:
    """One method a role; every implementation returns an iterable of Component."""

    @hookspec
    def mamo_backends(self) -> Iterable[Component]:  # type: ignore[empty-body]
        """Physics engines: build a ``TransitionModel``."""

    @hookspec
    def mamo_constraints(self) -> Iterable[Component]:  # type: ignore[empty-body]
        """Interaction constraints: build an ``InteractionConstraint``."""

    @hookspec
    def mamo_kinematics(self) -> Iterable[Component]:  # type: ignore[empty-body]
        """Arm kinematics: build a ``Kinematics``."""

    @hookspec
    def mamo_collision_checkers(self) -> Iterable[Component]:  # type: ignore[empty-body]
        """Collision checkers: build a ``CollisionChecker``."""

    @hookspec
    def mamo_arm_planners(self) -> Iterable[Component]:  # type: ignore[empty-body]
        """Motion planners: build an ``ArmPlanner``."""

    @hookspec
    def mamo_retrieval_planners(self) -> Iterable[Component]:  # type: ignore[empty-body]
        """Retrieval planners: build a ``RetrievalPlanner``."""

    @hookspec
    def mamo_mapf_solvers(self) -> Iterable[Component]:  # type: ignore[empty-body]
        """Multi-agent pathfinding solvers: build a ``MAPFSolver``."""

    @hookspec
    def mamo_actions(self) -> Iterable[Component]:  # type: ignore[empty-body]
        """Rearrangement actions: build an ``ActionGenerator``."""

    @hookspec
    def mamo_searches(self) -> Iterable[Component]:  # type: ignore[empty-body]
        """Search strategies: build a ``SearchStrategy``."""

    @hookspec
    def mamo_renderers(self) -> Iterable[Component]:  # type: ignore[empty-body]
        """Pictures in three dimensions: build a ``Renderer``; the context holds no other parts."""

    @hookspec
    def mamo_commands(self) -> Iterable[Component]:  # type: ignore[empty-body]
        """Commands of ``mamo``: build a function whose parameters typer makes options of.

        ``build(workbench, options)`` receives a ``mamo_core.cli.workbench.Workbench`` and is called
        only when the command is. ``learn_it`` becomes ``mamo learn-it``; no command of our own can
        be replaced.
        """


HOOK_OF_ROLE: dict[str, str] = {
    "backend": "mamo_backends",
    "constraint": "mamo_constraints",
    "kinematics": "mamo_kinematics",
    "collision": "mamo_collision_checkers",
    "arm_planner": "mamo_arm_planners",
    "retrieval": "mamo_retrieval_planners",
    "mapf": "mamo_mapf_solvers",
    "action": "mamo_actions",
    "search": "mamo_searches",
    "renderer": "mamo_renderers",
    "command": "mamo_commands",
}
"""Role, as recipes and listings name it, to its hook."""
