"""A plugin's package: the templates of its kind with its own name in them."""

from __future__ import annotations

import re
import shutil
from importlib.util import find_spec
from pathlib import Path

from mamo_core.atomic import atomic_folder
from mamo_core.errors import InputError, suggestion
from mamo_core.plugins import Registry

KINDS = ("backend", "action", "search", "mapf", "constraint")
"""Roles that there are templates for: ``templates/KIND``, over what is in ``templates/shared``."""

_NAME = re.compile(r"[a-z][a-z0-9]*(_[a-z0-9]+)*")
_TEMPLATES = Path(__file__).parent / "templates"
_IGNORED = shutil.ignore_patterns("__pycache__", ".*")


def folder_of(name: str) -> Path:
    """Where a package goes if nobody says otherwise, below the current folder."""
    return Path(f"mamo-{_hyphens(name)}")


def check_order(kind: str, name: str, registry: Registry) -> None:
    """Refuse a kind without templates, and a name that cannot be used.

    Raises:
        InputError: which of the two, the value and what is valid.
    """
    if kind not in KINDS:
        raise InputError(f"unknown KIND {kind!r}{suggestion(kind, KINDS)}")
    if not _NAME.fullmatch(name):
        raise InputError(
            f"NAME {name!r}, expected small letters, digits and single _ between them, a letter "
            "first, as in 'tall_push'"
        )
    for item in registry.registered:
        if (item.role, item.component.name) == (kind, name):
            raise InputError(
                f"NAME {name!r}: plugin {item.plugin!r} has the {kind} of this name; choose another"
            )
    if find_spec(f"mamo_{name}") is not None:
        raise InputError(
            f"NAME {name!r}: the Python package 'mamo_{name}' is installed; choose another"
        )


def write_package(kind: str, name: str, folder: Path) -> None:
    """Write the package to ``folder``, completely or not at all.

    Raises:
        InputError: the folder cannot be written or is not empty, or the class would be named like
            one that the code imports.
    """
    _check_class(kind, name)
    with atomic_folder(folder) as work:
        for part in ("shared", kind):
            shutil.copytree(_TEMPLATES / part, work, ignore=_IGNORED, dirs_exist_ok=True)
        _rename(work, kind, name)


def _rename(folder: Path, kind: str, name: str) -> None:
    """Put the name into every file, and into the name of the Python package."""
    words = _words(kind, name)
    placeholder = re.compile("|".join(words))
    for path in sorted(folder.rglob("*")):
        if path.is_file():
            text = path.read_text(encoding="utf-8")
            text = placeholder.sub(lambda found: words[found.group()], text)
            path.write_text(text, encoding="utf-8")
    (folder / f"mamo_my_{kind}").rename(folder / f"mamo_{name}")


def _words(kind: str, name: str) -> dict[str, str]:
    """What stands in the templates, to what comes in its place."""
    return {
        "my_plugin": name,
        "my-plugin": _hyphens(name),
        f"my_{kind}": name,
        f"my-{kind}": _hyphens(name),
        _placeholder_class(kind): _class_name(kind, name),
    }


def _placeholder_class(kind: str) -> str:
    return f"My{kind.capitalize()}"


def _class_name(kind: str, name: str) -> str:
    stem = name.removesuffix(f"_{kind}")
    return "".join(word.capitalize() for word in [*stem.split("_"), kind])


def _check_class(kind: str, name: str) -> None:
    """The class may not hide another one of the code's: think of an action ``rearrangement``."""
    own = _class_name(kind, name)
    for path in sorted((_TEMPLATES / kind).rglob("*.py")):
        others = path.read_text(encoding="utf-8").replace(_placeholder_class(kind), "")
        if re.search(rf"\b{own}(Options)?\b", others):
            raise InputError(
                f"NAME {name!r}: its class {own!r} would hide one of mamo's; choose another"
            )


def _hyphens(name: str) -> str:
    return name.replace("_", "-")
