"""Planners that the thesis compares itself with."""
