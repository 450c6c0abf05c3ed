"""Renderers by name."""

from __future__ import annotations

from mamo_core.build_context import BuildContext
from mamo_core.compose import build_component
from mamo_core.interfaces.renderer import Renderer
from mamo_core.plugins import Registry
from mamo_core.robots import load_arm
from mamo_core.types.problem import Problem

ROLE = "renderer"
DEFAULT = "mujoco"


def renderer_for(problem: Problem, registry: Registry, name: str = DEFAULT) -> Renderer:
    """The renderer of that name for recordings of a problem.

    Raises:
        InputError: there is none of that name, or the robot is not known.
        PluginError: the packages it needs are not installed.
    """
    component = registry.component(ROLE, name, "--renderer")
    context = BuildContext(problem=problem, robot=load_arm(problem.scene.robot))
    return build_component(ROLE, component, component.options(), context)
