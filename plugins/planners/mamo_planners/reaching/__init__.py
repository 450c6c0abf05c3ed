"""Planners whose arm pushes its way to a pre-grasp (thesis chapter 3), and what they share."""
