"""Gathers rearrangements and fits the learned priority of E-M4M to them (thesis 5.5.3)."""
