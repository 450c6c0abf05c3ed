"""Arms are built once, into a folder that is complete or not there."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from mamo_core.errors import InputError
from mamo_core.robots import build, library, load_arm
from mamo_core.robots.specs import PANDA, PR2_RIGHT_ARM

LOAD = """
from dataclasses import replace
from mamo_core.robots import build, library
coarse = {joint: 0.1 for joint in library.SPECS["panda"].joints}  # quick to cover
library.SPECS["panda"] = replace(
    library.SPECS["panda"], cover_slack=coarse, finger_slack=0.05
)
arm = library.load_arm("panda")
print(len(arm.links), arm.urdf.exists(), arm.links[-1].spheres.sum())
"""


@pytest.fixture(scope="module")
def twice_built(tmp_path_factory):
    """A cache that two processes filled at the same time, after a third one had crashed."""
    cache = tmp_path_factory.mktemp("cache")
    leftover = cache / "robots" / "panda-half"
    leftover.mkdir(parents=True)
    (leftover / "arm.json").write_text("{")
    environment = {**os.environ, "MAMO_CACHE": str(cache)}
    command = [sys.executable, "-c", LOAD]
    started = [
        subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        for _ in range(2)
    ]
    outputs = [process.communicate() for process in started]
    for process, (_, err) in zip(started, outputs, strict=True):
        assert process.returncode == 0, err
    return cache, [out for out, _ in outputs]


@pytest.fixture
def fresh_load(twice_built, monkeypatch):
    """``load_arm`` as a new process sees it, with that cache; building is an error."""
    load_arm("panda")  # remembered: other tests go on with the usual one
    monkeypatch.setenv("MAMO_CACHE", str(twice_built[0]))

    def no_building(spec, folder):
        raise AssertionError("built again")

    monkeypatch.setattr(build, "build_arm", no_building)
    return load_arm.__wrapped__


def test_two_processes_build_at_once(twice_built):
    cache, outputs = twice_built
    assert outputs[0] == outputs[1]
    assert outputs[0].split()[:2] == [b"9", b"True"]
    folder = cache / "robots" / f"panda-{library._content_hash(PANDA)}"
    assert sorted(p.name for p in folder.parent.iterdir()) == sorted([folder.name, "panda-half"])


def test_the_second_load_reads(fresh_load):
    read, usual = fresh_load("panda"), load_arm("panda")
    assert read.urdf.is_relative_to(library.cache_folder())
    assert read.joint_names == usual.joint_names
    for ours, theirs in zip(read.links, usual.links, strict=True):
        assert np.array_equal(ours.inertia, theirs.inertia)
        assert np.array_equal(ours.T_parent_joint, theirs.T_parent_joint)
        assert (ours.mass, ours.parent, ours.name) == (theirs.mass, theirs.parent, theirs.name)
        assert all(path.is_file() for path in (*ours.hulls, *ours.meshes))
    assert read.gripper.depth == usual.gripper.depth
    with pytest.raises(ValueError, match="read-only"):
        read.home[0] = 1.0


def test_the_urdf_names_files_in_its_final_place(fresh_load):
    text = fresh_load("panda").urdf.read_text()
    assert str(library.cache_folder()) in text
    names = [part.split('"')[0] for part in text.split('filename="')[1:]]
    assert names
    assert all(Path(name).is_file() for name in names)


def test_a_half_built_folder_is_not_used(fresh_load):
    # The crashed build's folder holds broken JSON: reading it would fail.
    assert (library.cache_folder() / "robots" / "panda-half" / "arm.json").exists()
    assert fresh_load("panda").name == "panda"


def test_a_build_that_fails_leaves_nothing(tmp_path, monkeypatch):
    monkeypatch.setenv("MAMO_CACHE", str(tmp_path))

    def broken(spec, folder):
        (folder / "arm.urdf").write_text("half")
        raise RuntimeError("no meshes")

    monkeypatch.setattr(build, "build_arm", broken)
    with pytest.raises(RuntimeError, match="no meshes"):
        load_arm.__wrapped__("panda")
    assert list((tmp_path / "robots").iterdir()) == []


def test_the_hash_depends_on_the_spec_and_on_the_code(tmp_path, monkeypatch):
    before = library._content_hash(PANDA)
    assert before != library._content_hash(PR2_RIGHT_ARM)
    copy = tmp_path / "robots"
    shutil.copytree(Path(build.__file__).parent, copy)
    monkeypatch.setattr(build, "__file__", str(copy / "build.py"))
    assert library._content_hash(PANDA) == before
    hashes = {before}
    for name in ("specs.py", "build.py", "model.py"):
        with open(copy / name, "a") as file:
            file.write("# changed\n")
        hashes.add(library._content_hash(PANDA))
    assert len(hashes) == 4


def test_unknown_robot():
    with pytest.raises(InputError) as caught:
        load_arm("pandas")
    assert str(caught.value) == (
        "robot 'pandas' is not known; did you mean 'panda'? (valid: panda, pr2_right_arm)"
    )


def test_cache_folder(monkeypatch, tmp_path):
    monkeypatch.delenv("MAMO_CACHE", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert library.cache_folder() == tmp_path / "mamo"
    monkeypatch.setenv("XDG_CACHE_HOME", "")
    assert library.cache_folder() == Path.home() / ".cache" / "mamo"
    monkeypatch.setenv("MAMO_CACHE", str(tmp_path / "own"))
    assert library.cache_folder() == tmp_path / "own"
