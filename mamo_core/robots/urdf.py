"""Writes a canonical arm as a URDF that every engine loads unchanged."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from mamo_core.robots.model import ArmModel, BodyPart, LinkModel
from mamo_core.types.geometry import Array


def write_urdf(arm: ArmModel) -> None:
    """Write ``arm.urdf``: base and body, one link a joint, convex hulls with absolute paths."""
    root = ElementTree.Element("robot", name=arm.name)
    ElementTree.SubElement(root, "link", name="base")
    for part in arm.body:
        root.extend(_fixed_elements(part))
    for link in arm.links:
        root.append(_link_element(link))
        root.append(_joint_element(arm, link))
    ElementTree.indent(root)
    ElementTree.ElementTree(root).write(arm.urdf, encoding="unicode", xml_declaration=True)


def _text(values: Array) -> str:
    return " ".join(f"{float(v):.12g}" for v in values)


def _rpy(rotation: Array) -> Array:
    pitch = np.arctan2(-rotation[2, 0], np.hypot(rotation[0, 0], rotation[1, 0]))
    if abs(np.cos(pitch)) < 1e-9:
        return np.array([0.0, pitch, np.arctan2(-rotation[0, 1], rotation[1, 1])])
    roll = np.arctan2(rotation[2, 1], rotation[2, 2])
    yaw = np.arctan2(rotation[1, 0], rotation[0, 0])
    return np.array([roll, pitch, yaw])


def _link_element(link: LinkModel) -> ElementTree.Element:
    element = ElementTree.Element("link", name=f"link_{link.name}")
    inertial = ElementTree.SubElement(element, "inertial")
    ElementTree.SubElement(inertial, "origin", xyz=_text(link.center_of_mass), rpy="0 0 0")
    ElementTree.SubElement(inertial, "mass", value=f"{link.mass:.12g}")
    i = link.inertia
    ElementTree.SubElement(
        inertial,
        "inertia",
        ixx=f"{i[0, 0]:.12g}",
        ixy=f"{i[0, 1]:.12g}",
        ixz=f"{i[0, 2]:.12g}",
        iyy=f"{i[1, 1]:.12g}",
        iyz=f"{i[1, 2]:.12g}",
        izz=f"{i[2, 2]:.12g}",
    )
    _add_hulls(element, link.hulls)
    return element


def _add_hulls(element: ElementTree.Element, hulls: Sequence[Path]) -> None:
    for hull in hulls:
        for role in ("visual", "collision"):
            geometry = ElementTree.SubElement(ElementTree.SubElement(element, role), "geometry")
            ElementTree.SubElement(geometry, "mesh", filename=str(hull))


def _fixed_elements(part: BodyPart) -> tuple[ElementTree.Element, ElementTree.Element]:
    """A link and the joint that fixes it to the base; both are called ``body_NAME``."""
    link = ElementTree.Element("link", name=f"body_{part.name}")
    _add_hulls(link, part.hulls)
    joint = ElementTree.Element("joint", name=f"body_{part.name}", type="fixed")
    ElementTree.SubElement(joint, "parent", link="base")
    ElementTree.SubElement(joint, "child", link=f"body_{part.name}")
    return link, joint


def _joint_element(arm: ArmModel, link: LinkModel) -> ElementTree.Element:
    kind = "prismatic" if link.prismatic else "revolute"
    element = ElementTree.Element("joint", name=link.name, type=kind)
    parent = "base" if link.parent < 0 else f"link_{arm.links[link.parent].name}"
    ElementTree.SubElement(element, "parent", link=parent)
    ElementTree.SubElement(element, "child", link=f"link_{link.name}")
    T = link.T_parent_joint
    ElementTree.SubElement(element, "origin", xyz=_text(T[:3, 3]), rpy=_text(_rpy(T[:3, :3])))
    ElementTree.SubElement(element, "axis", xyz=_text(link.axis))
    if link.coordinate < 0:
        table = arm.gripper.drive_of_opening[:, 1]
        lower, upper, velocity, effort = table[0], table[-1], 1.0, 100.0
    else:
        j = link.coordinate
        lower, upper = arm.lower[j], arm.upper[j]
        velocity, effort = arm.velocity[j], arm.effort[j]
    ElementTree.SubElement(
        element,
        "limit",
        lower=f"{lower:.12g}",
        upper=f"{upper:.12g}",
        velocity=f"{velocity:.12g}",
        effort=f"{effort:.12g}",
    )
    return element
