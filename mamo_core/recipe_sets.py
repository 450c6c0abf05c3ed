"""``--set key=value``: changes to a recipe that are reported under their own name."""

from __future__ import annotations

import copy
from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from mamo_core.config import Located, load_text
from mamo_core.errors import InputError, suggestion
from mamo_core.recipes import LoadedRecipe, find_recipe, load_recipe

Keys = tuple[str | int, ...]


def chosen_recipe(
    planner: str, backend: str | None = None, settings: tuple[str, ...] = ()
) -> LoadedRecipe:
    """The recipe with what the command line changes; ``--set`` comes after ``--backend``."""
    located = find_recipe(planner)
    if backend is not None and isinstance(located.data, dict):
        located = override(located, ["backend"], backend, "--backend")
    return load_recipe(apply_sets(located, settings))


def apply_sets(recipe: Located, settings: Iterable[str]) -> Located:
    """The recipe with settings such as ``search.iterate=false`` or ``actions.push.samples=3``.

    Values are read as YAML. Mistakes in them are later reported at ``--set KEY``.

    Raises:
        InputError: not of the form key=value, or the key leads nowhere.
    """
    for setting in settings:
        recipe = _apply(recipe, setting)
    return recipe


def _apply(recipe: Located, setting: str) -> Located:
    dotted, equals, text = setting.partition("=")
    keys = dotted.split(".")
    if not equals or "" in keys:
        raise InputError(f"--set {setting}: expected KEY=VALUE, for example search.iterate=false")
    origin = f"--set {dotted}"
    if not isinstance(recipe.data, dict):
        return recipe  # not a recipe at all: its validation says so
    return override(recipe, keys, load_text(text, origin).data, origin)


def override(recipe: Located, keys: list[str], value: Any, origin: str) -> Located:
    """The recipe with ``value`` under ``keys``; mistakes in it are reported at ``origin``."""
    data = copy.deepcopy(recipe.data)
    if keys[0] == "actions" and len(keys) > 1 and isinstance(data.get("actions"), dict | str):
        data["actions"] = [data["actions"]]
    path = _assign(data, keys, value, origin)
    said_by = {k: v for k, v in recipe.said_by.items() if k[: len(path)] != path}
    return replace(recipe, data=data, said_by={**said_by, path: origin})


def _assign(data: Any, keys: list[str], value: Any, origin: str) -> Keys:
    """Put ``value`` under ``keys``; the path of the topmost thing that is new."""
    path: Keys = ()
    new: Keys | None = None
    container = data
    for depth, key in enumerate(keys):
        step = _step(container, key, ".".join(keys[:depth]), origin)
        path = (*path, step)
        if depth == len(keys) - 1:
            container[step] = value
        elif isinstance(container, dict) and container.get(step) is None:
            container[step] = {}
            new = path if new is None else new
        elif isinstance(container[step], str):  # the short form of a part: its name alone
            container[step] = {"name": container[step]}
        container = container[step]
    return new if new is not None else path


def _step(container: Any, key: str, dotted: str, origin: str) -> str | int:
    """The key, or the place in a list: of the part with that name, or counted from 0."""
    if isinstance(container, dict):
        return key
    if not isinstance(container, list):
        raise InputError(f"{origin}: {dotted!r} holds {container!r}, which has no keys")
    names = [item.get("name") if isinstance(item, dict) else item for item in container]
    if key in names:
        return names.index(key)
    if key.isdecimal() and int(key) < len(container):
        return int(key)
    hint = suggestion(key, (name for name in names if isinstance(name, str)))
    raise InputError(f"{origin}: no {key!r} in {dotted!r}{hint}")
