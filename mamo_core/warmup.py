"""Everything slow that needs to happen only once: robot caches and compiled kernels."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Collection, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed

from mamo_core.hookspecs import Component
from mamo_core.plugins import Registry, discover


def warm_up(registry: Registry) -> Iterator[str]:
    """Build the robots we know, compile our own kernels, then run every plugin's ``warm_up``.

    Plugins compile side by side, each in a process of its own; what they leave is on disk. Yields
    the name of each piece when it is done.
    """
    from mamo_core.robots.specs import SPECS

    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(mp_context=context) as pool:
        for robot, _ in _done(pool, _build_robot, list(SPECS)):
            yield f"robot {robot}"
        pool.submit(_warm_trajectories).result()
        yield "trajectories"
        for plugin, known in _done(pool, _warm_plugin, list(registry.warm_ups)):
            if not known:
                registry.warm_ups[plugin]()
            yield f"plugin {plugin}"


def load_kernels(registry: Registry, components: Collection[Component] | None = None) -> None:
    """Have this process read what was compiled, so that nothing waits for it later.

    With ``components`` only the plugins that brought one of them are loaded; what trajectories are
    made with always is.
    """
    _warm_trajectories()
    wanted = {
        item.plugin
        for item in registry.registered
        if components is None or item.component in components
    }
    for plugin, run in registry.warm_ups.items():
        if plugin in wanted:
            run()


def _done(
    pool: ProcessPoolExecutor, task: Callable[[str], bool], names: Sequence[str]
) -> Iterator[tuple[str, bool]]:
    running: dict[Future[bool], str] = {pool.submit(task, name): name for name in names}
    for future in as_completed(running):
        yield running[future], future.result()


def _build_robot(name: str) -> bool:
    from mamo_core.robots import load_arm

    load_arm(name)
    return True


def _warm_trajectories() -> None:
    from mamo_core.robots.timing_kernels import warm_up as compile_all

    compile_all()


def _warm_plugin(name: str) -> bool:
    """False for a plugin that another process registered by hand: it is unknown here."""
    run = discover().warm_ups.get(name)
    if run is None:
        return False
    run()
    return True
