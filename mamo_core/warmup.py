"""Everything slow that needs to happen only once: robot caches and compiled kernels."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed

from mamo_core.plugins import Registry, discover


def warm_up(registry: Registry) -> Iterator[str]:
    """Build the robots we know, then run the ``warm_up`` of every plugin that has one.

    Plugins compile side by side, each in a process of its own; what they leave on disk is then
    loaded here, so that this process is warm, too. Yields the name of each piece when it is done.
    """
    from mamo_core.robots.specs import SPECS

    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(mp_context=context) as pool:
        yield from _done(pool, "robot", _build_robot, list(SPECS))
        yield from _done(pool, "plugin", _warm_plugin, list(registry.warm_ups))
    for run in registry.warm_ups.values():
        run()


def _done(
    pool: ProcessPoolExecutor, kind: str, task: Callable[[str], None], names: Sequence[str]
) -> Iterator[str]:
    running: dict[Future[None], str] = {pool.submit(task, name): name for name in names}
    for future in as_completed(running):
        future.result()
        yield f"{kind} {running[future]}"


def _build_robot(name: str) -> None:
    from mamo_core.robots import load_arm

    load_arm(name)


def _warm_plugin(name: str) -> None:
    """A plugin that is registered by hand alone is unknown here; its own process warms it."""
    run = discover().warm_ups.get(name)
    if run is not None:
        run()
