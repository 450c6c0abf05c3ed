"""The robot's contacts with itself: reported, and without force, as such a rollout fails anyway."""

from __future__ import annotations

from typing import Any

import mujoco

from mamo_core.robots.model import ArmModel

_MARK = "self:"
_GAP = 1.0
"""Contacts exert a force only this deep in, m: never."""


def add_body(spec: Any, base: Any, arm: ArmModel) -> None:
    """Hulls of the parts that do not move and that the arm may touch; they meet nothing else."""
    links = len(arm.links)
    met = {other for _, other in arm.hull_pairs}
    for number, part in enumerate(arm.body, start=links):
        for k, hull in enumerate(part.hulls if number in met else ()):
            name = _geom(arm, number, k)
            spec.add_mesh(name=name, file=str(hull))
            base.add_geom(
                name=name,
                type=mujoco.mjtGeom.mjGEOM_MESH,
                meshname=name,
                contype=0,
                conaffinity=0,
                mass=0.0,
            )


def add_own_pairs(spec: Any, arm: ArmModel) -> None:
    """Have the hulls of ``arm.hull_pairs`` looked at, and no others of the robot's own."""
    parts = arm.parts
    for one, other in arm.hull_pairs:
        for k in range(len(parts[one].hulls)):
            for n in range(len(parts[other].hulls)):
                a, b = _geom(arm, one, k), _geom(arm, other, n)
                spec.add_pair(
                    name=f"{_MARK}{a}|{b}",
                    geomname1=a,
                    geomname2=b,
                    condim=1,
                    margin=-_GAP,
                    gap=_GAP,
                )


def is_own(pair_name: str) -> bool:
    """Whether a pair is of the robot with itself."""
    return pair_name.startswith(_MARK)


def _geom(arm: ArmModel, number: int, hull: int) -> str:
    links = len(arm.links)
    if number < links:
        return f"{arm.links[number].name}:{hull}"
    return f"body:{arm.body[number - links].name}:{hull}"
