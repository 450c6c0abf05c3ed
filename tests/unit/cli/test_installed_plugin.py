"""An installed distribution is found, listed and used like any other plugin."""

import json
import os
import subprocess
import sys

import pytest

from mamo_core.scaffold.package import write_package


@pytest.fixture
def package(tmp_path):
    write_package("action", "shove", tmp_path / "own")
    return tmp_path / "own"


def mamo(environment, *arguments):
    command = [sys.executable, "-c", "from mamo_core.cli.main import main; main()", *arguments]
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=False)


def test_it_is_listed(package, install):
    done = mamo(install(package), "plugins", "list", "--json")
    assert done.returncode == 0, done.stderr
    document = json.loads(done.stdout)
    shove = [c for c in document["components"] if c["plugin"] == "shove"]
    assert shove == [
        {
            "role": "action",
            "name": "shove",
            "plugin": "shove",
            "summary": "straight pushes along the way an object should go",
            "provides": [],
        }
    ]
    assert "shove" not in [problem["plugin"] for problem in document["problems"]]


def test_without_it_there_is_no_shove():
    done = mamo(dict(os.environ), "plugins", "list", "--json")
    assert "shove" not in done.stdout


def test_who_lacks_it_can_verify_its_plans(package, install):
    plan = package / "plan.json"
    files = package / "problem.yaml", package / "recipe.yaml"
    done = mamo(
        install(package),
        *("plan", str(files[0]), "--planner", str(files[1]), "-o", str(plan)),
        *("--budget", "600", "--json"),
    )
    assert done.returncode == 0, done.stdout + done.stderr
    document = json.loads(done.stdout)
    assert (document["status"], document["verified"]) == ("solved", True)
    assert document["actions"] == [{"kind": "shove", "object": "blocker"}]
    again = mamo(dict(os.environ), "verify", str(plan))
    assert again.returncode == 0, again.stdout + again.stderr
