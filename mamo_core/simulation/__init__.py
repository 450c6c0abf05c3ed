"""Turns an engine's world into a transition model: one way to execute a motion for all engines."""
