"""``mamo plugins``: what is installed, whether it keeps its promises, and how to begin one."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

app = typer.Typer(help="Look at plugins and their components, or begin one.", no_args_is_help=True)


@app.command("list")
def list_(
    json: Annotated[
        bool, typer.Option("--json", help="Print one JSON document instead of a table.")
    ] = False,
) -> None:
    """List all components by role, and the plugins that are disabled."""
    from mamo_core.cli.output import print_json, print_table, warn_of_broken_plugins
    from mamo_core.plugins import Registered, discover

    def row(item: Registered) -> dict[str, Any]:
        component = item.component
        return {
            "role": item.role,
            "name": component.name,
            "plugin": item.plugin,
            "summary": component.summary,
            "provides": sorted(component.provides),
        }

    registry = discover()
    rows = [row(item) for item in registry.registered]
    if json:
        problems = [{"plugin": p.plugin, "message": p.message} for p in registry.problems]
        print_json("plugins list", {"components": rows, "problems": problems})
        return
    rows.sort(key=lambda data: data["role"])
    columns = ("role", "name", "plugin", "summary")
    print_table("components", columns, ([data[key] for key in columns] for data in rows))
    warn_of_broken_plugins(registry)


@app.command("check")
def check(
    name: Annotated[str, typer.Argument(metavar="BACKEND", help="Name of a physics engine.")],
    json: Annotated[
        bool, typer.Option("--json", help="Print one JSON document instead of a table.")
    ] = False,
) -> None:
    """Run the conformance suite on a backend.

    The exit code is 4 if it does not keep a promise.
    """
    from mamo_core.cli.checking import run_plugin_check

    raise typer.Exit(run_plugin_check(name, as_json=json))


@app.command("new")
def new(
    kind: Annotated[
        str, typer.Argument(metavar="KIND", help="backend, action, search, mapf or constraint.")
    ],
    name: Annotated[str, typer.Argument(metavar="NAME", help="Name of the component, as in YAML.")],
    output: Annotated[
        Path | None,
        typer.Option(
            "-o", "--output", metavar="FOLDER", help="New or empty folder (default: mamo-NAME)."
        ),
    ] = None,
) -> None:
    """Write a package with a component of your own that works, ready to be edited.

    It has tests, a recipe or a problem that uses it, and a README.
    """
    from mamo_core.cli.creating import run_new

    run_new(kind, name, output)
