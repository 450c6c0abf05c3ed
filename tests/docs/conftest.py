"""The scripts that write pages and pictures have their folder on the path, as when they run."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parents[2] / "tools"))
