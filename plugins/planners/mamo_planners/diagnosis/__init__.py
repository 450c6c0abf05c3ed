"""Where no plan was found: a second look at the initial scene, for what stands in the way."""

from mamo_planners.diagnosis.initial_scene import diagnose

__all__ = ["diagnose"]
