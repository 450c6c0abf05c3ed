"""Packages for plugin authors, made from templates that work as they stand."""
