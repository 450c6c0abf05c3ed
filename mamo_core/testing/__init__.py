"""For plugin authors and for searches: contract tests, fakes, tiny scenes with known answers."""
