"""Sampling-based baselines: KPIECE (K1, K2, K3) and RRT, with an engine in the loop."""
