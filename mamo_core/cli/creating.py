"""The work behind ``mamo plugins new``."""

from __future__ import annotations

import shlex
from pathlib import Path

from mamo_core.cli.output import warn_of_broken_plugins
from mamo_core.errors import InputError
from mamo_core.plugins import discover
from mamo_core.scaffold.package import check_order, folder_of, write_package


def run_new(kind: str, name: str, folder: Path | None) -> None:
    """Write the package of a plugin, and tell what to do next."""
    registry = discover()
    try:
        check_order(kind, name, registry)
    except InputError as error:
        raise InputError(f"mamo plugins new: {error}") from None
    warn_of_broken_plugins(registry)
    target = folder_of(name) if folder is None else folder
    write_package(kind, name, target)
    print(f"{target}: a plugin with the {kind} {name!r}, which works as it stands")
    print(f"edit {target / f'mamo_{name}' / f'{kind}.py'}, and read {target / 'README.md'}")
    print("next:")
    for command in _next(kind, target):
        print(f"    {command}")


def _next(kind: str, target: Path) -> list[str]:
    """Commands to a plan that uses the plugin, from the current folder."""
    folder = str(target) if target.is_absolute() else f"./{target}"
    problem, recipe = (shlex.quote(str(target / file)) for file in ("problem.yaml", "recipe.yaml"))
    planner = "" if kind == "constraint" else f" --planner {recipe}"
    return [
        f"python -m pip install -e {shlex.quote(f'{folder}[test]')}",
        f"python -m pytest {shlex.quote(str(target))}",
        f"mamo plan {problem}{planner} -o plan.json --png plan.png",
        "mamo verify plan.json",
    ]
