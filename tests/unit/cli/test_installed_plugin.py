"""The example distribution is found, listed and checked like any other plugin."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

SMALL = Path(__file__).parents[2] / "golden" / "small_shelf.yaml"
EXAMPLE = Path(__file__).parents[3] / "examples" / "third_party_plugin"


@pytest.fixture
def environment(install):
    return install(EXAMPLE)


def mamo(environment, *arguments):
    command = [sys.executable, "-c", "from mamo_core.cli.main import main; main()", *arguments]
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=False)


def test_it_is_listed(environment):
    done = mamo(environment, "plugins", "list", "--json")
    assert done.returncode == 0, done.stderr
    document = json.loads(done.stdout)
    shove = [c for c in document["components"] if c["plugin"] == "shove"]
    assert shove == [
        {
            "role": "action",
            "name": "shove",
            "plugin": "shove",
            "summary": "push an object from a random side",
            "provides": [],
        }
    ]
    assert "shove" not in [problem["plugin"] for problem in document["problems"]]


def test_without_it_there_is_no_shove():
    done = mamo(dict(os.environ), "plugins", "list", "--json")
    assert "shove" not in done.stdout


def test_a_plan_with_it_passes_verification(environment, tmp_path):
    """Its own recipe; pushes are refused, so that its own action has to do the work."""
    plan = tmp_path / "plan.json"
    done = mamo(
        environment,
        *("plan", str(SMALL), "--planner", str(EXAMPLE / "shove.yaml"), "-o", str(plan)),
        *("--set", "actions.push.shortest=9", "--budget", "600", "--json"),
    )
    assert done.returncode == 0, done.stdout + done.stderr
    document = json.loads(done.stdout)
    assert (document["status"], document["verified"]) == ("solved", True)
    assert {"kind": "shove", "object": "blocker"} in document["actions"]
    assert {action["kind"] for action in document["actions"]} == {"shove"}
    again = mamo(dict(os.environ), "verify", str(plan))
    assert again.returncode == 0, again.stdout + again.stderr
