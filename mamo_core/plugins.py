"""Finds plugins and keeps their components; a broken plugin disables only itself."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from importlib.metadata import EntryPoint, entry_points
from types import ModuleType
from typing import Any

import pluggy

from mamo_core.errors import InputError, PluginError, suggestion
from mamo_core.hookspecs import ENTRY_POINT_GROUP, HOOK_OF_ROLE, Component, HookSpecs, Options
from mamo_core.stale_kernels import forget_stale_kernels, package_folders

WARM_UP = "warm_up"
"""Optional function without arguments in a plugin's module: compiles or caches what is slow."""


@dataclass(frozen=True)
class BrokenPlugin:
    """Why a plugin is disabled."""

    plugin: str
    message: str

    def __str__(self) -> str:
        return f"plugin {self.plugin!r} is disabled: {self.message}"


@dataclass(frozen=True)
class Registered:
    """A component and the plugin that brought it."""

    role: str
    plugin: str
    component: Component


@dataclass(frozen=True)
class Registry:
    """All components of all working plugins, and what is wrong with the others."""

    registered: tuple[Registered, ...]
    problems: tuple[BrokenPlugin, ...] = ()
    warm_ups: Mapping[str, Callable[[], Any]] = field(default_factory=dict)

    def components(self, role: str) -> tuple[Component, ...]:
        """The components of a role, in the order they were registered."""
        return tuple(item.component for item in self.registered if item.role == role)

    def component(self, role: str, name: str, where: str = "") -> Component:
        """The component of that role and name; ``where`` is the place that asks for it.

        Raises:
            InputError: no such component; with the names there are.
            PluginError: nothing is named like it and a plugin that may have brought it is broken.
        """
        found = {component.name: component for component in self.components(role)}
        if name in found:
            return found[name]
        hint = suggestion(name, found)
        message = f"{where}{': ' if where else ''}unknown {role} {name!r}{hint}"
        if self.problems and "did you mean" not in hint:
            raise PluginError("\n".join([message, *map(str, self.problems)]))
        raise InputError(message)


class _DisableError(Exception):
    """Its text says why the plugin cannot be used."""


def discover() -> Registry:
    """The registry of everything installed under the entry-point group ``mamo``.

    What was compiled before a kernel changed is forgotten first.
    """
    found = sorted(entry_points(group=ENTRY_POINT_GROUP), key=_own_first)
    forget_stale_kernels(package_folders([__name__, *(entry.module for entry in found)]))
    return make_registry([(entry.name, partial(_load, entry)) for entry in found])


def make_registry(plugins: Sequence[tuple[str, Callable[[], Any]]]) -> Registry:
    """A registry of named plugins, each given by a function that imports it."""
    registered: list[Registered] = []
    problems: list[BrokenPlugin] = []
    warm_ups: dict[str, Callable[[], Any]] = {}
    for name, load in plugins:
        try:
            plugin = load()
            offered = _components(name, plugin)
            _refuse_twice([*registered, *offered])
            warm_up = _warm_up(plugin)
        except _DisableError as broken:
            problems.append(BrokenPlugin(name, str(broken)))
            continue
        registered += offered
        if warm_up is not None:
            warm_ups[name] = warm_up
    return Registry(tuple(registered), tuple(problems), warm_ups)


def _own_first(entry: EntryPoint) -> tuple[bool, str, str]:
    """Our own plugins come first, so that nobody disables them by using one of their names."""
    distribution = entry.dist.name if entry.dist else ""
    return distribution != "mamo", entry.name, entry.value


def _load(entry: EntryPoint) -> ModuleType:
    try:
        return entry.load()
    except Exception as error:
        raise _DisableError(f"{entry.value} cannot be imported: {_words(error)}") from error


def _components(name: str, plugin: Any) -> list[Registered]:
    """What one plugin offers; it has a manager of its own, so that it cannot break the others."""
    manager = pluggy.PluginManager(ENTRY_POINT_GROUP)
    manager.add_hookspecs(HookSpecs)
    try:
        manager.register(plugin, name)
    except pluggy.PluginValidationError as error:
        raise _DisableError(_flat(str(error))) from error
    _refuse_unknown_hooks(manager, plugin)
    return [
        Registered(role, name, component)
        for role, hook in HOOK_OF_ROLE.items()
        for component in _call(manager, hook)
    ]


def _refuse_unknown_hooks(manager: pluggy.PluginManager, plugin: Any) -> None:
    for attribute in dir(plugin):
        is_hook = manager.parse_hookimpl_opts(plugin, attribute) is not None
        if is_hook and attribute not in HOOK_OF_ROLE.values():
            hint = suggestion(attribute, HOOK_OF_ROLE.values())
            raise _DisableError(f"unknown hook {attribute!r}{hint}")


def _call(manager: pluggy.PluginManager, hook: str) -> list[Component]:
    try:
        results = getattr(manager.hook, hook)()
        offered = [_listed(result, hook) for result in results]
    except _DisableError:
        raise
    except Exception as error:
        raise _DisableError(f"hook {hook}: {_words(error)}") from error
    components = [component for part in offered for component in part]
    for i, component in enumerate(components):
        _check_component(component, f"hook {hook}: item {i}")
    return components


def _listed(result: Any, hook: str) -> list[Any]:
    if isinstance(result, str | bytes | Mapping) or not isinstance(result, Iterable):
        kind = type(result).__name__
        raise _DisableError(f"hook {hook}: returned a {kind}, expected a list of Component")
    return list(result)


def _check_component(component: Any, where: str) -> None:
    if not isinstance(component, Component):
        raise _DisableError(f"{where}: a {type(component).__name__}, expected a Component")
    for argument, is_right, expected in _RULES:
        value = getattr(component, argument)
        if not is_right(value):
            raise _DisableError(f"{where}: Component({argument}={value!r}), expected {expected}")


def _is_requirement(value: Any) -> bool:
    return isinstance(value, dict) and all(
        role in HOOK_OF_ROLE and isinstance(needed, frozenset) for role, needed in value.items()
    )


_RULES: tuple[tuple[str, Callable[[Any], bool], str], ...] = (
    ("name", lambda v: isinstance(v, str) and v.isidentifier(), "letters, digits and _"),
    ("build", callable, "a function (context, options)"),
    ("options", lambda v: inspect.isclass(v) and issubclass(v, Options), "a subclass of Options"),
    ("summary", lambda v: isinstance(v, str), "text"),
    ("provides", lambda v: isinstance(v, frozenset), "a frozenset of capabilities"),
    (
        "requires",
        _is_requirement,
        f"a dict of role to frozenset (roles: {', '.join(HOOK_OF_ROLE)})",
    ),
)


def _refuse_twice(registered: list[Registered]) -> None:
    first: dict[tuple[str, str], str] = {}
    for item in registered:
        key = (item.role, item.component.name)
        if key in first:
            raise _DisableError(
                f"hook {HOOK_OF_ROLE[item.role]}: {item.role} {item.component.name!r} "
                f"is already registered by plugin {first[key]!r}"
            )
        first[key] = item.plugin


def _warm_up(plugin: Any) -> Callable[[], Any] | None:
    function = getattr(plugin, WARM_UP, None)
    if function is not None and not callable(function):
        raise _DisableError(f"{WARM_UP} is a {type(function).__name__}, expected a function")
    return function


def _words(error: Exception) -> str:
    return _flat(f"{type(error).__name__}: {error}")


def _flat(text: str) -> str:
    return " ".join(text.split())
