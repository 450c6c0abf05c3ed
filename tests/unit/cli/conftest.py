"""Runs commands in this process, with a toy plugin found as any installed plugin is.

For new processes it installs whole distributions.
"""

import os
import shutil
import signal
import sys
import tomllib
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import NamedTuple

import numpy as np
import pytest

import mamo_core.cli.viewing  # before the fakes: it keeps what it imports
import mamo_core.robots
from mamo_core.cli.main import main
from mamo_core.verify import VerifyReport

RECIPE = """\
schema_version: 1
name: toy_planner
backend: toy_engine
kinematics: toy
collision: toy
arm_planner: toy
retrieval: toy
actions: toy
search: toy
"""
PROBLEM = """\
schema_version: 1
name: two_things
robot: {name: pr2_right_arm, joints: [0, 0, 0, 0, 0, 0, 0]}
workspace: {lower: [0, -0.5, 0], upper: [1, 0.5, 1]}
objects:
  - {name: t, box: [0.06, 0.06, 0.2], position: [0.5, 0.2, 0.1], mass: 0.4, friction: 0.5}
  - {name: o1, box: [0.06, 0.06, 0.2], position: [0.3, 0.2, 0.1], mass: 0.4, friction: 0.5}
target: t
grasps:
  - {position: [-0.1, 0, 0], approach: 0.1, opening: 0.07}
"""


@pytest.fixture
def install(tmp_path):
    """``install(folder)`` gives the environment of a process that finds the distribution there.

    It leaves behind what ``pip install --target`` would, without a network or a build tool.
    """

    def install(folder):
        with open(folder / "pyproject.toml", "rb") as file:
            document = tomllib.load(file)
        project, site = document["project"], tmp_path / "site-packages"
        for package in document["tool"]["hatch"]["build"]["targets"]["wheel"]["packages"]:
            shutil.copytree(folder / package, site / package, dirs_exist_ok=True)
        info = site / f"{project['name'].replace('-', '_')}-{project['version']}.dist-info"
        info.mkdir(exist_ok=True)
        (info / "METADATA").write_text(
            f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {project['version']}\n"
        )
        entries = project["entry-points"]["mamo"]
        lines = "".join(f"{name} = {module}\n" for name, module in entries.items())
        (info / "entry_points.txt").write_text(f"[mamo]\n{lines}")
        return {**os.environ, "PYTHONPATH": str(site), "PYTHONDONTWRITEBYTECODE": "1"}

    return install


class Outcome(NamedTuple):
    code: int
    out: str
    err: str


@pytest.fixture
def run(tmp_path, monkeypatch, capsys):
    """``run("plan", ...)`` in an empty folder with ``problem.yaml`` and ``toy.yaml``."""
    install_toys(tmp_path / "site", monkeypatch)
    work = tmp_path / "work"
    work.mkdir()
    (work / "problem.yaml").write_text(PROBLEM)
    (work / "toy.yaml").write_text(RECIPE)
    monkeypatch.chdir(work)
    fake_what_is_slow(monkeypatch)
    handler = signal.getsignal(signal.SIGINT)

    def run(*arguments):
        with pytest.raises(SystemExit) as caught:
            main([str(argument) for argument in arguments])
        out, err = capsys.readouterr()
        return Outcome(caught.value.code, out, err)

    yield run
    signal.signal(signal.SIGINT, handler)


def install_toys(site, monkeypatch):
    site.mkdir()
    shutil.copy(Path(__file__).parent / "toy_plugin.py", site / "toy_plugin.py")
    info = site / "toys-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: toys\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[mamo]\ntoys = toy_plugin\n")
    monkeypatch.syspath_prepend(site)
    monkeypatch.delitem(sys.modules, "toy_plugin", raising=False)


def fake_what_is_slow(monkeypatch):
    """A robot without meshes, a verifier that believes the toy engine, a picture in words."""
    joints = tuple(f"j{i}" for i in range(7))
    robot = SimpleNamespace(
        name="pr2_right_arm", dof=7, joint_names=joints, lower=-np.ones(7), upper=np.ones(7)
    )
    monkeypatch.setattr(mamo_core.robots, "load_arm", lambda name: robot)

    def verify(problem, plan, model, robot, parameters=None):
        failures = ("tilt: o1 at 1.000 s",) if model.breaks else ()
        return VerifyReport(failures, None)

    def draw(problem, plan=None, final_state=None, path=None):
        Path(path).write_text(f"{problem.name} {plan is not None}")

    # The command line replays; what a search executed itself is nothing for it.
    fakes = {"mamo_core.verify": {"verify": verify, "verify_executed": None}}
    fakes["mamo_core.verify"] |= {
        "verify_replays": lambda report, *around: report,
        "verify_by_friction": None,  # the toys have no engine that could
    }
    fakes["mamo_core.margin"] = {
        "margin_of": lambda *_: {"1 mm": 0.9},
        "possible_poses": None,
    }
    fakes["mamo_core.view.topdown"] = {"draw": draw}
    fakes["mamo_core.view.failure"] = {
        "draw_failure": lambda problem, path, **words: Path(path).write_text(problem.name)
    }
    for name, functions in fakes.items():
        module = ModuleType(name)
        vars(module).update(functions)
        monkeypatch.setitem(sys.modules, name, module)
