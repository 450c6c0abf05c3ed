"""Pictures of problems and plans; matplotlib is imported when the first one is drawn."""
