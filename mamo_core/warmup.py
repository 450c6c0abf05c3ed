"""Everything slow that needs to happen only once: robot caches and compiled kernels."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

from mamo_core.plugins import Registry


@dataclass(frozen=True)
class WarmUpStep:
    """A piece of the warm-up: ``run`` may take seconds the first time."""

    name: str
    run: Callable[[], Any]


def warm_up_steps(registry: Registry) -> Iterator[WarmUpStep]:
    """The robots we know, then whatever the plugins bring (``warm_up`` in their module)."""
    from mamo_core.robots import load_arm
    from mamo_core.robots.specs import SPECS

    for robot in SPECS:
        yield WarmUpStep(f"robot {robot}", partial(load_arm, robot))
    for plugin, run in registry.warm_ups.items():
        yield WarmUpStep(f"plugin {plugin}", run)
