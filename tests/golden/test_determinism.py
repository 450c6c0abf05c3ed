"""The same seed gives the same plan file in another process, also when the machine is busy."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

SMALL = Path(__file__).parent / "small_shelf.yaml"
MAIN = "from mamo_core.cli.main import main; main()"


def mamo(*arguments):
    command = [sys.executable, "-c", MAIN, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.fixture(scope="module")
def plan_files(tmp_path_factory):
    """The first in peace, the second beside a busy process."""
    folder = tmp_path_factory.mktemp("plans")
    busy = None
    try:
        for name in ("a.json", "b.json"):
            done = mamo("plan", SMALL, "--seed", 2, "--budget", 600, "-o", folder / name)
            assert done.returncode == 0, done.stdout + done.stderr
            if busy is None:
                busy = subprocess.Popen([sys.executable, "-c", "while True: pass"])
    finally:
        if busy is not None:
            busy.kill()
            busy.wait()
    return folder / "a.json", folder / "b.json"


def test_the_same_bytes(plan_files):
    one, other = (path.read_bytes() for path in plan_files)
    assert one == other


def test_there_is_something_to_repeat(plan_files):
    document = json.loads(plan_files[0].read_text())
    assert [action["object"] for action in document["actions"]] == ["blocker"]


def test_another_process_verifies_it(plan_files):
    done = mamo("verify", plan_files[0])
    assert done.returncode == 0, done.stdout + done.stderr
    words = f"{plan_files[0]}: verified with mujoco, in the world of the plan file itself\n"
    assert done.stdout == words


def test_it_holds_in_the_world_that_a_user_names(plan_files):
    done = mamo("verify", plan_files[0], "--problem", SMALL)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout == f"{plan_files[0]}: verified with mujoco, in the world of {SMALL}\n"
