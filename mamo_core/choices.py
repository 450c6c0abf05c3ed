"""Which components a recipe asks for, and whether they fit each other."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from mamo_core.config import Located, validated
from mamo_core.errors import InputError
from mamo_core.hookspecs import Component, Options
from mamo_core.plugins import Registry
from mamo_core.recipes import LoadedRecipe
from mamo_core.types.problem import Problem

BUILD_ORDER = (
    "constraint",
    "backend",
    "accept_in",
    "kinematics",
    "collision",
    "arm_planner",
    "retrieval",
    "mapf",
    "action",
    "search",
)
_KIND = {"accept_in": "backend"}
"""Roles that are filled with components of another role."""


@dataclass(frozen=True, eq=False)
class Choice:
    """A component with its options, and the place that asked for it."""

    role: str
    component: Component
    options: Options
    place: str


def choose(
    recipe: LoadedRecipe,
    problem: Problem,
    registry: Registry,
    roles: Collection[str] = BUILD_ORDER,
) -> tuple[Choice, ...]:
    """The components of some roles, in building order, checked against each other.

    Raises:
        InputError: unknown component, wrong options, a capability that is missing, or a search
            that does not plan for the task of the problem.
    """
    choices: list[Choice] = []
    for role in BUILD_ORDER:
        if role == "constraint" and role in roles:
            choices += constraint_choices(problem, partial(registry.component, role))
        elif role == "accept_in" and role in roles:
            choices += _other_engines(recipe, registry)
        elif role in roles:
            choices += [
                _choice(registry, role, part.name, part.options, part.place)
                for part in recipe.parts(role)
            ]
    check_requirements(choices)
    for choice in choices:
        if choice.role == "search":
            _check_task(choice, problem)
    return tuple(choices)


def check_requirements(choices: Sequence[Choice]) -> None:
    """Refuse a recipe with a component that needs what another one does not provide."""
    for choice in choices:
        for role, needed in choice.component.requires.items():
            others = [other for other in choices if role in (other.role, _KIND.get(other.role))]
            if not others:
                raise InputError(f"{choice.place}: {_named(choice)} needs a part {role!r}")
            for other in others:
                _check_provides(choice, other, needed)
        for role, needed in choice.options.needs().items():
            for other in (other for other in choices if other.role == role):
                _check_provides(choice, other, needed)


def constraint_choices(problem: Problem, find: Callable[[str, str], Component]) -> list[Choice]:
    """``find``: a constraint by its name, and the place that asks for it."""
    place = f"problem {problem.name!r}: constraints"
    choices = []
    for spec in problem.constraints:
        component = find(spec.name, place)
        options = Located(dict(spec.options), f"{place}: {spec.name}")
        choices.append(
            Choice("constraint", component, validated(component.options, options), place)
        )
    return choices


def _other_engines(recipe: LoadedRecipe, registry: Registry) -> list[Choice]:
    """The engines of ``accept_in`` that are not the backend itself, the cheapest first."""
    own = {part.name for part in recipe.parts("backend")}
    others = [
        replace(_choice(registry, "backend", p.name, p.options, p.place), role="accept_in")
        for p in recipe.parts("accept_in")
        if p.name not in own
    ]
    return sorted(others, key=lambda choice: choice.component.cost)


def _choice(registry: Registry, role: str, name: str, options: Located, place: str) -> Choice:
    component = registry.component(role, name, place)
    return Choice(role, component, validated(component.options, options), place)


def _check_provides(choice: Choice, other: Choice, needed: Collection[str]) -> None:
    missing = sorted(set(needed) - other.component.provides)
    if missing:
        provided = ", ".join(sorted(other.component.provides)) or "nothing"
        raise InputError(
            f"{choice.place}: {_named(choice)} needs {', '.join(missing)} from the {other.role}, "
            f"but {_named(other)} provides {provided}"
        )


def _check_task(search: Choice, problem: Problem) -> None:
    if problem.task not in search.component.tasks:
        tasks = ", ".join(sorted(search.component.tasks))
        raise InputError(
            f"{search.place}: {_named(search)} does not plan for the task {problem.task.value!r} "
            f"of problem {problem.name!r} (it does for: {tasks})"
        )


def changed(choice: Choice, changes: Mapping[str, Any]) -> Choice:
    """The same component with some other options."""
    own = choice.options.model_dump(exclude_unset=True)
    place = f"{choice.place}: changed options of {_named(choice)}"
    return replace(
        choice,
        options=validated(choice.component.options, Located({**own, **changes}, place)),
    )


def _named(choice: Choice) -> str:
    return f"{choice.role} {choice.component.name!r}"
