"""The same plan in several engines: where they part, and what that costs."""
