"""Arm planners of the Open Motion Planning Library (OMPL) over any of our collision checkers."""
