"""Studies: many problems with many planners, kept in a store that survives everything."""
