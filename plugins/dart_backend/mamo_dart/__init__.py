"""The DART backend."""
