"""Commands in a new process, as a user runs them."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

MAMO = [sys.executable, "-c", "from mamo_core.cli.main import main; main()"]


@pytest.fixture
def panda():
    return Path(__file__).parents[2] / "problems" / "panda_open_shelf.yaml"


@pytest.fixture
def mamo(tmp_path):
    """``mamo("plan", ...)`` in an empty folder; ``path`` is searched for modules first."""

    def run(*arguments, path=None):
        environment = dict(os.environ)
        if path is not None:
            environment["PYTHONPATH"] = str(path)
        command = [*MAMO, *map(str, arguments)]
        return subprocess.run(
            command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
        )

    return run
