"""Multi-agent pathfinding of large footprints: who moves where, without physics (thesis 4.4.1).

``components`` lists what recipes can name; importing it compiles nothing.
"""

from __future__ import annotations


def warm_up() -> None:
    """Compiles (or loads from the cache) every kernel of this package."""
    from mamo_planners.mapf.warm import warm_up as run

    run()
