"""The commands with real engines: a plan in each, comparison, conformance, a missing package."""

import json

import pytest

from mamo_core.recording import read_recording

ENGINES = ("mujoco", "pybullet", "dart")


@pytest.mark.parametrize("engine", ENGINES)
def test_the_panda_plans_and_stdout_holds_the_result_alone(mamo, panda, engine):
    done = mamo("plan", panda, "--backend", engine, "--json")
    assert done.returncode == 0, done.stderr
    document = json.loads(done.stdout)
    assert document["verified"]
    assert document["actions"]  # something stands in the way
    assert document["cpu_s"] >= sum(document["parts"].values())
    assert "build time" not in done.stderr  # PyBullet's greeting


def test_a_plan_that_all_engines_accept(mamo, panda):
    settings = ("--set", "accept_in=[dart, mujoco, pybullet]")
    done = mamo("plan", panda, *settings, "-o", "plan.json")
    assert done.returncode == 0, done.stderr
    assert mamo("verify", "plan.json").returncode == 0
    for engine in ENGINES:
        assert mamo("verify", "plan.json", "--backend", engine).returncode == 0


def test_compare(mamo, panda, tmp_path):
    files = ("-o", "report.json", "--png", "engines.png", "--trace", "tracks.npz")
    done = mamo("compare", panda, "--backends", "mujoco,pybullet", "--samples", 1, *files, "--json")
    assert done.returncode == 0, done.stderr
    report = json.loads((tmp_path / "report.json").read_text())
    printed = json.loads(done.stdout)
    assert printed["transfer"] == report["transfer"]
    cells = {(row["planned_with"], row["executed_in"]): row for row in report["transfer"]}
    assert len(cells) == 4
    assert cells["mujoco", "mujoco"]["valid"] == cells["mujoco", "mujoco"]["plans"] == 1
    first = report["plans"][0]
    assert [d["action"] for d in first["divergences"]] == list(range(len(first["actions"])))
    assert all(d["chaos_floor_mm"][0] is not None for d in first["divergences"])
    assert (tmp_path / "engines.png").read_bytes().startswith(b"\x89PNG")
    recording = read_recording(tmp_path / "tracks.npz")
    assert [e.engine for e in recording.executions] == ["mujoco", "pybullet"]
    for execution in recording.executions:
        assert len(execution.poses) == len(recording.times)
        assert execution.contacts.dtype == bool


def test_a_recording_is_shown_without_its_engine(mamo, panda, tmp_path):
    """The plan executed once, kept, and drawn again where PyBullet is not installed."""
    assert mamo("plan", panda, "-o", "plan.json", "--graph", "search.svg").returncode == 0
    assert (tmp_path / "search.svg").read_text().startswith("<svg")
    files = ("-o", "kept.npz", "--png", "first.png")
    done = mamo("view", "plan.json", "--backends", "pybullet", *files, "--json")
    assert done.returncode == 0, done.stderr
    assert list(json.loads(done.stdout)["failures"]) == ["pybullet"]
    (tmp_path / "pybullet.py").write_text("raise ModuleNotFoundError")
    again = mamo("view", "kept.npz", "--png", "again.png", path=tmp_path)
    assert again.returncode == 0, again.stderr
    assert (tmp_path / "first.png").read_bytes() == (tmp_path / "again.png").read_bytes()


def test_plugins_check(mamo):
    done = mamo("plugins", "check", "mujoco", "--json")
    assert done.returncode == 0, done.stderr
    document = json.loads(done.stdout)
    assert document["summary"] == {
        "passed": 46,
        "failed": 0,
        "declared_unsupported": 1,
        "known_gaps": 0,
        "skipped_undeclared": 0,
    }
    unsupported = [c for c in document["checks"] if c["verdict"] == "declared_unsupported"]
    assert [check["name"] for check in unsupported] == ["killed"]


def test_plugins_check_of_nothing(mamo):
    done = mamo("plugins", "check", "bullet")
    assert done.returncode == 2
    assert "did you mean 'pybullet'" in done.stderr


@pytest.mark.parametrize(("engine", "module"), [("dart", "dartpy"), ("pybullet", "pybullet")])
def test_a_package_that_is_not_there(mamo, panda, tmp_path, engine, module):
    site = tmp_path / "site"
    site.mkdir()
    (site / f"{module}.py").write_text(
        f"raise ModuleNotFoundError(\"No module named '{module}'\", name='{module}')\n"
    )
    done = mamo("plan", panda, "--backend", engine, path=site)
    assert done.returncode == 5
    assert f"pip install 'mamo[{engine}]'" in done.stderr
    assert mamo("plan", panda, path=site).returncode == 0
