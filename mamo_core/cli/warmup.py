"""``mamo warmup``: do now what would make the first plan slow."""

from __future__ import annotations

import typer


def warmup() -> None:
    """Build robot caches and compile kernels.

    The commands after it start at once.
    """
    import time

    from mamo_core.cli.output import progress, warn_of_broken_plugins
    from mamo_core.plugins import discover
    from mamo_core.warmup import warm_up

    registry = discover()
    warn_of_broken_plugins(registry)
    started = time.monotonic()
    with progress() as tell:
        tell("building robots and compiling kernels")
        for piece in warm_up(registry):
            tell(f"{piece} is ready")
    typer.echo(f"ready after {time.monotonic() - started:.1f} s")
