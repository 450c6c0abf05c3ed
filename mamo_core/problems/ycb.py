"""Objects of the YCB set, as upright boxes and cylinders.

The thesis draws the objects of its workspaces from that set (3.5.1). Masses are those of the set's
object list as other public code quotes it, not compared with the original: B. Calli, A. Walsman,
A. Singh, S. Srinivasa, P. Abbeel and A. M. Dollar, "Benchmarking in Manipulation Research: The YCB
Object and Model Set and Benchmarking Protocols", IEEE Robotics and Automation Magazine 22(3), 2015;
as a file at ycbbenchmarks.com. Extents are those of the boxes that the thesis' author used for the
objects; the foam brick's are quoted from the list. What is round is a cylinder here, of the box's
width; handles and spouts are left out.

Left out is what does not stand, what a box or cylinder does not resemble, and what is lighter than
``MINIMUM_MASS``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mamo_core.types.geometry import Box, Cylinder, Shape


@dataclass(frozen=True, eq=False)
class YcbObject:
    """``id`` as the set's files are named, such as ``003_cracker_box``; ``shape`` stands upright
    in its own frame; ``mass`` in kg."""

    id: str
    shape: Shape
    mass: float

    @property
    def name(self) -> str:
        """The id without its number, such as ``cracker_box``."""
        return self.id.split("_", 1)[1]


def _box(x: float, y: float, z: float) -> Box:
    """Full extents in mm."""
    return Box(np.array([x, y, z]) / 1000.0)


def _cylinder(diameter: float, height: float) -> Cylinder:
    """Full extents in mm."""
    return Cylinder(diameter / 2000.0, height / 1000.0)


CATALOGUE: tuple[YcbObject, ...] = (
    YcbObject("002_master_chef_can", _cylinder(102, 139), 0.414),
    YcbObject("003_cracker_box", _box(60, 158, 210), 0.411),
    YcbObject("004_sugar_box", _box(38, 89, 175), 0.514),
    YcbObject("005_tomato_soup_can", _cylinder(66, 101), 0.349),
    YcbObject("006_mustard_bottle", _box(50, 85, 175), 0.603),
    YcbObject("008_pudding_box", _box(110, 35, 89), 0.187),
    YcbObject("009_gelatin_box", _box(85, 28, 73), 0.097),
    YcbObject("010_potted_meat_can", _box(50, 97, 82), 0.370),
    YcbObject("019_pitcher_base", _cylinder(108, 235), 0.178),
    YcbObject("021_bleach_cleanser", _box(64, 98, 250), 1.131),
    YcbObject("025_mug", _cylinder(82, 80), 0.118),
    YcbObject("036_wood_block", _box(85, 85, 200), 0.729),
    YcbObject("061_foam_brick", _box(50, 75, 50), 0.028),
)
