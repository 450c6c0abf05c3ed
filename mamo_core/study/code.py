"""Which code a row was made with."""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Iterable, Iterator
from functools import cache
from importlib.metadata import PackageNotFoundError, entry_points, version
from importlib.util import find_spec
from pathlib import Path

from mamo_core.hookspecs import ENTRY_POINT_GROUP

NO_INFLUENCE = ("cli", "compare", "study", "testing", "view")
"""Rooms of the core that cannot change what a planner does."""

MEASURES = ("study/solving.py", "study/replay.py")
"""... but these do the measuring."""

PACKAGES = (
    *("dartpy", "example-robot-data", "mamo", "mujoco", "numba", "numpy", "pin", "pybullet"),
    *("python-fcl", "scipy", "trimesh"),
)


@cache
def code_version() -> str:
    """A hash of the source of the core and of all plugins, and of the packages they rest on.

    It is the same on all machines with the same code.
    """
    digest = hashlib.sha256(f"python {sys.version_info[:2]}".encode())
    for package in PACKAGES:
        digest.update(f"{package} {_version(package)}\n".encode())
    for name, file in _sources():
        digest.update(name.encode())
        digest.update(file.read_bytes())
    return digest.hexdigest()[:12]


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "missing"


def _sources() -> Iterator[tuple[str, Path]]:
    """Names and files, sorted."""
    modules = {entry.module.split(".")[0] for entry in entry_points(group=ENTRY_POINT_GROUP)}
    for module in sorted({"mamo_core", *modules}):
        spec = find_spec(module)
        if spec is None or spec.origin is None:
            continue
        origin = Path(spec.origin)
        files: Iterable[Path] = [origin]
        if origin.name == "__init__.py":
            files = sorted(origin.parent.rglob("*.py"))
        for file in files:
            name = file.relative_to(origin.parent).as_posix()
            if module != "mamo_core" or _counts(name):
                yield f"{module}/{name}", file


def _counts(name: str) -> bool:
    return name in MEASURES or name.split("/")[0] not in NO_INFLUENCE
