"""The page of components: what each role offers, and every option."""

from __future__ import annotations

from collections.abc import Iterator
from importlib.metadata import distribution

from mamo_core.hookspecs import ENTRY_POINT_GROUP, HOOK_OF_ROLE, Component
from mamo_core.plugins import Registry, make_registry
from reference_pages.fields import fields_table
from reference_pages.markdown import page, prose, summary

INTRODUCTION = """\
The components that come with mamo, by role, and their options as they stand in a recipe beside
`name` (those of constraints stand in a problem, under `options`). `mamo plugins list` shows also
what other installed packages bring. Numbers are in SI units and radians unless something else is
said."""


def own_registry() -> Registry:
    """Our own plugins alone, whatever else is installed."""
    own = distribution("mamo").entry_points.select(group=ENTRY_POINT_GROUP)
    return make_registry([(entry.name, entry.load) for entry in sorted(own, key=lambda e: e.name)])


def options_page() -> str:
    """Every component with its options."""
    registry = own_registry()
    return page("Components and their options", INTRODUCTION, *_roles(registry))


def _roles(registry: Registry) -> Iterator[str]:
    for role in HOOK_OF_ROLE:
        yield f"## Role `{role}`"
        shown: dict[type, str] = {}
        for component in registry.components(role):
            yield from _component(component, shown)


def _component(component: Component, shown: dict[type, str]) -> Iterator[str]:
    """``shown``: the models of options that stand above already, and where."""
    yield f"### `{component.name}`"
    yield _about(component)
    if not component.options.model_fields:
        yield "No options."
    elif component.options in shown:
        yield f"Options: those of `{shown[component.options]}`."
    else:
        shown[component.options] = component.name
        yield fields_table(component.options)


def _about(component: Component) -> str:
    said = prose(component.summary) or summary(component.options)
    words = [f"{said[:1].upper()}{said[1:]}."]
    if component.provides:
        words.append(f"Provides {_names(component.provides)}.")
    for role, needed in component.requires.items():
        words.append(
            f"Needs {_names(needed)} from the part `{role}`."
            if needed
            else f"Needs a part `{role}`."
        )
    if component.tasks != frozenset({"retrieve"}):
        words.append(f"Plans for the tasks {_names(component.tasks)}.")
    if component.extra:
        words.append(f"Installed by `pip install 'mamo[{component.extra}]'`.")
    return " ".join(words)


def _names(names: frozenset[str]) -> str:
    return ", ".join(f"`{name}`" for name in sorted(names))
