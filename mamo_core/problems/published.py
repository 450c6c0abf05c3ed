"""Where the published scenes lie: ``MAMO_SCENES``, or ``shared/scenes`` beside the repository."""

from __future__ import annotations

import os
from pathlib import Path

from mamo_core.errors import InputError

VARIABLE = "MAMO_SCENES"


def scenes_folder() -> Path:
    """The folder, whether it exists or not."""
    named = os.environ.get(VARIABLE)
    return Path(named) if named else Path(__file__).parents[3] / "shared" / "scenes"


def published_scenes(name: str) -> Path:
    """A file of published scenes.

    Raises:
        InputError: it is not there; with the place where it was looked for.
    """
    path = scenes_folder() / name
    if not path.is_file():
        raise InputError(
            f"{path}: no such file of published scenes (set {VARIABLE} to their folder)"
        )
    return path
