"""Contacts that are reported from a distance on, and exert no force before there is none.

MuJoCo calls that distance a gap. What happens is the same, bit for bit, as without.
"""

from __future__ import annotations

from typing import Any

import mujoco

from mamo_core.types.problem import Problem
from mamo_core.types.scene import Mobility


def add_immovable_pairs(spec: Any, problem: Problem, solref: list[float]) -> None:
    """Pairs of a movable and an immovable object; those with the target are there already."""
    objects = problem.scene.objects
    for one in (o.name for o in objects if o.mobility is Mobility.MOVABLE):
        for other in (o.name for o in objects if o.mobility is Mobility.IMMOVABLE):
            spec.add_pair(
                name=f"{one}|{other}", geomname1=one, geomname2=other, condim=3, solref=solref
            )


def keep_clear(model: Any, problem: Problem, clearance: float) -> None:
    """Have movable objects touch all others from ``clearance`` (m) on.

    Those that stand nearer than twice of it touch from half their distance on: nobody may begin
    with a contact.
    """
    movable = {o.name for o in problem.scene.objects if o.mobility is Mobility.MOVABLE}
    guarded = {o.name for o in problem.scene.objects} - movable
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    for pair in range(model.npair):
        names = set(model.pair(pair).name.split("|"))
        if names & movable and names & guarded:
            geoms = int(model.pair_geom1[pair]), int(model.pair_geom2[pair])
            apart = mujoco.mj_geomDistance(model, data, *geoms, 2.0 * clearance, None)
            model.pair_gap[pair] = max(0.0, apart) / 2.0
