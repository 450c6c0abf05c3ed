"""Files and folders that are written completely or not at all."""

from __future__ import annotations

import os
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from mamo_core.errors import InputError


def check_writable(path: str | Path) -> None:
    """Find out before the work, not after it, that a result cannot be written.

    Raises:
        InputError: the folder is missing or not writable, or ``path`` is no regular file.
    """
    target = Path(path)
    if not target.parent.is_dir():
        raise InputError(f"{target}: no such folder {str(target.parent)!r}")
    if target.exists() and not target.is_file():  # renaming would replace a device such as null
        kind = "folder" if target.is_dir() else "device or pipe"
        raise InputError(f"{target}: is a {kind}, expected a file")
    if not os.access(target.parent, os.W_OK):
        raise InputError(f"{target}: folder {str(target.parent)!r} cannot be written")


def check_folder(path: str | Path, wanted: str = "a folder") -> None:
    """Find out before the work that a folder of results cannot be made or written.

    Raises:
        InputError: ``path`` is a file, the folder around it is missing, or it is not writable.
    """
    target = Path(path)
    if target.exists() and not target.is_dir():
        raise InputError(f"{target}: is a file, expected {wanted}")
    nearest = target if target.is_dir() else target.parent
    if not nearest.is_dir():
        raise InputError(f"{target}: no such folder {str(target.parent)!r}")
    if not os.access(nearest, os.W_OK):
        raise InputError(f"{target}: folder {str(nearest)!r} cannot be written")


@contextmanager
def atomic_path(path: str | Path) -> Iterator[Path]:
    """A path to write to, renamed to ``path`` in the end, or deleted if the block fails.

    It has the same ending, by which many writers choose their format.
    """
    check_writable(path)
    target = Path(path).resolve()  # a link goes on pointing to the file
    work = target.with_name(f".{secrets.token_hex(4)}.{target.name}")
    try:
        yield work
        os.replace(work, target)
    finally:
        work.unlink(missing_ok=True)


@contextmanager
def atomic_folder(path: str | Path) -> Iterator[Path]:
    """A folder to fill, whose entries are moved to ``path`` in the end; nothing if the block fails.

    Raises:
        InputError: ``path`` is a file or a folder that is not empty, or cannot be written.
    """
    target = Path(path)
    _check_free(target)
    is_new = not target.exists()
    work = target / f".{secrets.token_hex(4)}"
    try:
        target.mkdir(exist_ok=True)
        work.mkdir()
        yield work
        for entry in sorted(work.iterdir()):
            os.replace(entry, target / entry.name)
        work.rmdir()
    except BaseException:
        shutil.rmtree(target if is_new else work, ignore_errors=True)
        raise


def _check_free(target: Path) -> None:
    check_folder(target, "a new or an empty folder")
    if target.is_dir() and any(target.iterdir()):
        raise InputError(f"{target}: the folder is not empty, expected a new or an empty one")
