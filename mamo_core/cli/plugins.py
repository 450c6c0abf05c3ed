"""``mamo plugins``: what is installed."""

from __future__ import annotations

from typing import Annotated, Any

import typer

app = typer.Typer(help="Look at plugins and their components.", no_args_is_help=True)


@app.callback()
def _plugins() -> None:
    """Keeps ``list`` a command of its own while it is the only one."""


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
