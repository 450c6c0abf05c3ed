"""Canonical arm models: one description for planning and for every engine."""

from mamo_core.robots.library import load_arm
from mamo_core.robots.model import ArmModel

__all__ = ["ArmModel", "load_arm"]
