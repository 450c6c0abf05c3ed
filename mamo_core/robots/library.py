"""Canonical arms by name, built once and kept in the user's cache folder."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import tempfile
from dataclasses import fields, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from mamo_core.errors import InputError, suggestion
from mamo_core.robots import build, spheres
from mamo_core.robots.distance_field import read_fields, write_fields
from mamo_core.robots.model import ArmModel, BodyPart, GripperModel, LinkModel
from mamo_core.robots.pair_table import read_tables, write_tables
from mamo_core.robots.specs import SPECS, ArmSpec, robot_data_folder


def cache_folder() -> Path:
    """``MAMO_CACHE``, else ``mamo`` in the user's cache folder."""
    chosen = os.environ.get("MAMO_CACHE")
    if chosen:
        return Path(chosen)
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "mamo"


@cache
def load_arm(name: str) -> ArmModel:
    """The canonical arm called ``name``; built on first use (seconds), then read (milliseconds).

    Raises:
        InputError: there is no such robot.
    """
    if name not in SPECS:
        raise InputError(f"robot {name!r} is not known{suggestion(name, SPECS)}")
    spec = SPECS[name]
    folder = cache_folder() / "robots" / f"{name}-{_content_hash(spec)}"
    if not (folder / "arm.json").exists():
        _build_into(spec, folder)
    return _read(folder)


def _content_hash(spec: ArmSpec) -> str:
    """Hash of everything the result depends on: the model's files and the code that cuts it."""
    digest = hashlib.sha256()
    source = robot_data_folder() / Path(spec.urdf).parts[0]
    files = [robot_data_folder() / spec.urdf, *sorted(source.glob("meshes/**/*.stl"))]
    code = Path(build.__file__).parent
    names = [
        "body",
        "build",
        "distance_field",
        "kinematics",
        "model",
        "pair_table",
        "self_pairs",
        "specs",
        "urdf",
    ]
    files += [code / f"{name}.py" for name in names]
    files.append(Path(spheres.__file__))
    for file in files:
        digest.update(file.read_bytes())
    return digest.hexdigest()[:16]


def _build_into(spec: ArmSpec, folder: Path) -> None:
    """Build beside the final place and rename, so that a half-built arm is never seen."""
    folder.parent.mkdir(parents=True, exist_ok=True)
    work = Path(tempfile.mkdtemp(prefix=f"{spec.name}-", dir=folder.parent))
    try:
        arm = build.build_arm(spec, work)
        text = (work / "arm.urdf").read_text().replace(str(work), str(folder))
        (work / "arm.urdf").write_text(text)
        write_fields(arm.fields, work / "fields.npz")
        write_tables(arm.tables, work / "tables.npz")
        bare = replace(arm, fields=(), tables=())
        (work / "arm.json").write_text(json.dumps(_encode(bare)))
        _put_in_place(work, folder)
    finally:
        shutil.rmtree(work, ignore_errors=True)


def _put_in_place(work: Path, folder: Path) -> None:
    """Rename, unless another process was faster, whose result is the same."""
    try:
        work.rename(folder)
    except OSError:
        if not (folder / "arm.json").exists():
            # Something emptied the folder, a cleaner of temporary files perhaps.
            shutil.rmtree(folder, ignore_errors=True)
            work.rename(folder)


def _encode(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, Path):
        return value.name
    if isinstance(value, tuple):
        return [_encode(v) for v in value]
    if hasattr(value, "__dataclass_fields__"):
        return {f.name: _encode(getattr(value, f.name)) for f in fields(value)}
    return value


def _read(folder: Path) -> ArmModel:
    data = json.loads((folder / "arm.json").read_text())
    gripper = data["gripper"]
    return ArmModel(
        name=data["name"],
        joint_names=tuple(data["joint_names"]),
        lower=_array(data["lower"]),
        upper=_array(data["upper"]),
        velocity=_array(data["velocity"]),
        acceleration=_array(data["acceleration"]),
        jerk=_array(data["jerk"]),
        effort=_array(data["effort"]),
        links=tuple(_link(item, folder) for item in data["links"]),
        tool_link=data["tool_link"],
        T_link_tool=_array(data["T_link_tool"]),
        gripper=GripperModel(
            _array(gripper["drive_of_opening"]),
            gripper["depth"],
            gripper["speed"],
            gripper["force"],
        ),
        home=_array(data["home"]),
        body=tuple(_body_part(item, folder) for item in data["body"]),
        urdf=folder / data["urdf"],
        self_pairs=_pairs(data["self_pairs"]),
        hull_pairs=_pairs(data["hull_pairs"]),
        fields=read_fields(folder / "fields.npz"),
        tables=read_tables(folder / "tables.npz"),
    )


def _body_part(item: dict[str, Any], folder: Path) -> BodyPart:
    hulls, meshes = (tuple(folder / name for name in item[key]) for key in ("hulls", "meshes"))
    return BodyPart(item["name"], hulls, meshes)


def _pairs(rows: list[list[int]]) -> tuple[tuple[int, int], ...]:
    return tuple((one, other) for one, other in rows)


def _link(item: dict[str, Any], folder: Path) -> LinkModel:
    arrays = ("T_parent_joint", "axis", "center_of_mass", "inertia")
    paths = ("hulls", "meshes")
    values = {
        **item,
        **{key: _array(item[key]) for key in arrays},
        **{key: tuple(folder / name for name in item[key]) for key in paths},
        "spheres": _array(item["spheres"]).reshape(-1, 4),
    }
    return LinkModel(**values)


def _array(values: Any) -> Any:
    array = np.array(values, dtype=np.float64)
    array.flags.writeable = False
    return array
