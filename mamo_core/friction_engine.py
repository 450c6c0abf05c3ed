"""An engine in which fingers and friction hold things, whatever engine a recipe plans with."""

from __future__ import annotations

from mamo_core.choices import Choice, constraint_choices
from mamo_core.compose import build_parts
from mamo_core.config import Located, validated
from mamo_core.errors import InputError
from mamo_core.interfaces.transition_model import TransitionModel
from mamo_core.plugins import Registry
from mamo_core.robots.model import ArmModel
from mamo_core.types.problem import Problem
from mamo_core.verdict import FRICTION_GRASPS

_PLACE = "the execution by friction"


def friction_model(
    problem: Problem, registry: Registry, robot: ArmModel | None = None, backend: str = "mujoco"
) -> TransitionModel:
    """The engine with its default options, but without welds.

    Raises:
        InputError: the backend cannot hold things so, or is not known.
    """
    component = registry.component("backend", backend, _PLACE)
    if FRICTION_GRASPS not in component.provides:
        able = [c.name for c in registry.components("backend") if FRICTION_GRASPS in c.provides]
        raise InputError(
            f"{_PLACE}: backend {backend!r} holds things by welds alone (it does not provide "
            f"{FRICTION_GRASPS}; those that do: {', '.join(sorted(able)) or 'none'})"
        )
    options = validated(component.options, Located({"grasp": "friction"}, _PLACE))
    constraints = constraint_choices(
        problem, lambda name, place: registry.component("constraint", name, place)
    )
    choices = [*constraints, Choice("backend", component, options, _PLACE)]
    model: TransitionModel = build_parts(choices, problem, robot).part("backend")
    return model
